//! The cylinder, the obstacle that stands still or wanders.

use nalgebra::{Isometry2, Point2};
use parry2d::math::{Pose, Vector};
use parry2d::shape::Ball;

use super::contact;
use super::robot::Footprint;

/// The radius of a cylinder, in metres: half a foot.
pub const CYLINDER_RADIUS: f64 = 0.1524;

/// The height of a cylinder, in metres.
pub const CYLINDER_HEIGHT: f64 = 0.3;

/// One cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    pub(super) pose: Isometry2<f64>,
}

impl Cylinder {
    /// A cylinder that stands still.
    pub(super) fn standing(centre: Point2<f64>) -> Self {
        Self { pose: Isometry2::translation(centre.x, centre.y) }
    }

    /// The pose of its axis. The heading is where a moving cylinder last wanted to go; that of
    /// one that stands still is 0.
    pub fn pose(&self) -> &Isometry2<f64> {
        &self.pose
    }

    /// Where its axis is.
    pub fn centre(&self) -> Point2<f64> {
        self.pose.translation.vector.into()
    }

    /// Whether the footprint reaches the cylinder.
    pub(super) fn touches(&self, footprint: &Footprint) -> bool {
        touches_at(&self.centre(), footprint)
    }
}

/// Whether the footprint reaches a cylinder with this centre.
pub(super) fn touches_at(centre: &Point2<f64>, footprint: &Footprint) -> bool {
    let centre: Vector = contact::point(centre);
    footprint.touches(&Pose::from_translation(centre), &Ball::new(CYLINDER_RADIUS as f32))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    #[test]
    fn is_touched_by_the_robots_side_and_corner() {
        let cylinder = Cylinder::standing(Point2::new(0.2, -0.1));
        // Radius 0.1524 and half a side 0.075, or half a diagonal 0.10607.
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
