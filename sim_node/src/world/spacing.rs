//! Placement rules for the centres of cylinders.

use nalgebra::{Point2, distance_squared};

/// Placement rules for cylinders, in metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spacing {
    /// Half the side length of the central square, in which all centres must be.
    pub(super) half_square: f64,
    /// Minimum distance between two centres.
    pub(super) apart: f64,
    /// Minimum distance between the centre of a cylinder and that of the robot at the start.
    pub(super) from_robot: f64,
}

impl Spacing {
    /// The rules for static cylinders.
    pub(super) const STATIC: Self = Self { half_square: 0.7, apart: 0.7, from_robot: 0.5 };

    /// The rules for moving cylinders. They may be at any distance from the robot as long as they
    /// do not touch it.
    pub(super) const MOVING: Self = Self { half_square: 0.75, apart: 0.5, from_robot: 0.0 };

    /// Returns whether a centre is in the central square.
    pub(super) fn contains(&self, centre: &Point2<f64>) -> bool {
        let square = -self.half_square..=self.half_square;
        square.contains(&centre.x) && square.contains(&centre.y)
    }

    /// Returns whether two centres are far enough apart.
    pub(super) fn separates(&self, first: &Point2<f64>, second: &Point2<f64>) -> bool {
        distance_squared(first, second) >= self.apart * self.apart
    }
}
