//! Where the centres of cylinders may be.

use nalgebra::{Point2, distance_squared};

/// The distances that cylinders keep, in metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spacing {
    /// Centres are within this distance of both axes of the room: in a central square.
    pub(super) half_square: f64,
    /// Centres are at least this far from each other.
    pub(super) apart: f64,
    /// Centres are at least this far from the centre of the robot, where it starts.
    pub(super) from_robot: f64,
}

impl Spacing {
    /// Of cylinders that stand still.
    pub(super) const STANDING: Self = Self { half_square: 0.7, apart: 0.7, from_robot: 0.5 };

    /// Of cylinders that move. They may come as close to the robot as it takes not to touch it.
    pub(super) const MOVING: Self = Self { half_square: 0.75, apart: 0.5, from_robot: 0.0 };

    /// Whether a centre is in the central square.
    pub(super) fn contains(&self, centre: &Point2<f64>) -> bool {
        let square = -self.half_square..=self.half_square;
        square.contains(&centre.x) && square.contains(&centre.y)
    }

    /// Whether two centres are far enough apart.
    pub(super) fn separates(&self, first: &Point2<f64>, second: &Point2<f64>) -> bool {
        distance_squared(first, second) >= self.apart * self.apart
    }
}
