//! Cylinders: static or moving obstacles.

use nalgebra::{Isometry2, Point2};
use parry2d::math::{Pose, Vector};
use parry2d::shape::Ball;

use super::contact;
use super::robot::Footprint;

/// Radius of a cylinder in metres: half a foot.
pub const CYLINDER_RADIUS: f64 = 0.1524;

/// Height of a cylinder in metres.
pub const CYLINDER_HEIGHT: f64 = 0.3;

/// A vertical cylinder that stands on the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    pub(super) pose: Isometry2<f64>,
}

impl Cylinder {
    /// Creates a cylinder with heading 0.
    pub(super) fn new(centre: Point2<f64>) -> Self {
        Self { pose: Isometry2::translation(centre.x, centre.y) }
    }

    /// Returns the pose of the axis in the frame of the room, in metres and radians.
    ///
    /// At its next step, a moving cylinder turns from this heading by a random angle before it
    /// moves. The heading of a static cylinder is 0.
    pub fn pose(&self) -> &Isometry2<f64> {
        &self.pose
    }

    /// Returns the position of the axis in the frame of the room, in metres.
    pub fn centre(&self) -> Point2<f64> {
        self.pose.translation.vector.into()
    }

    /// Returns whether the footprint touches the cylinder.
    pub(super) fn touches(&self, footprint: &Footprint) -> bool {
        touches_at(&self.centre(), footprint)
    }
}

/// Returns whether the footprint touches a cylinder with this centre.
pub(super) fn touches_at(centre: &Point2<f64>, footprint: &Footprint) -> bool {
    let centre: Vector = contact::point(centre);
    footprint.touches(&Pose::from_translation(centre), &Ball::new(CYLINDER_RADIUS as f32))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    #[test]
    fn touches_the_side_or_the_corner_of_the_robot() {
        let cylinder = Cylinder::new(Point2::new(0.2, -0.1));
        // The limit is the sum of the cylinder's radius, 0.1524 m, and half the robot's side, 0.075
        // m, or half its diagonal, 0.10607 m.
        for (distance, degrees, expected) in [
            (0.2275, 0.0_f64, false),
            (0.2273, 0.0, true),
            (0.2586, 45.0, false),
            (0.2584, 45.0, true),
            (0.0, 0.0, true),
        ] {
            let robot = Isometry2::new(Vector2::new(0.2 + distance, -0.1), degrees.to_radians());
            assert_eq!(cylinder.touches(&Footprint::at(&robot)), expected, "{distance} m");
        }
    }
}
