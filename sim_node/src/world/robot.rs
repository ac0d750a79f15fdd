//! The robot: a square that turns and moves forward.

use nalgebra::{Isometry2, UnitComplex, Vector2};
use parry2d::math::{Pose, Vector};
use parry2d::shape::{Cuboid, Shape};
use task::Action;
use task::action::STEP_LENGTH;

use super::contact;

/// Side length of the robot's square footprint in metres.
pub const FOOTPRINT_SIDE: f64 = 0.15;

/// Returns the pose after an action that is not blocked: first the turn, then the step forward
/// (equation 3 of the paper).
pub(super) fn moved(robot: &Isometry2<f64>, action: Action) -> Isometry2<f64> {
    let mut moved = *robot;
    moved.append_rotation_wrt_center_mut(&UnitComplex::new(action.turn()));
    // Each product of rotations is rounded. Without renormalization, the heading would lose its
    // unit length.
    moved.rotation.renormalize();
    moved.translation.vector += moved.rotation * Vector2::new(STEP_LENGTH, 0.0);
    moved
}

/// The area of the ground plan that the robot covers at a pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Footprint {
    pose: Pose,
    shape: Cuboid,
}

impl Footprint {
    /// Returns the footprint of the robot at the pose `robot`.
    pub(super) fn at(robot: &Isometry2<f64>) -> Self {
        let half_side = (FOOTPRINT_SIDE / 2.0) as f32;
        Self { pose: contact::pose(robot), shape: Cuboid::new(Vector::splat(half_side)) }
    }

    /// Returns whether the footprint has a point in common with `shape` at `pose`.
    pub(super) fn touches(&self, pose: &Pose, shape: &dyn Shape) -> bool {
        contact::touch(&self.pose, &self.shape, pose, shape)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    use super::*;

    #[test]
    fn an_action_turns_before_it_moves_forward() {
        let robot = Isometry2::new(Vector2::new(0.5, -0.25), FRAC_PI_2);
        let moved = moved(&robot, Action::ALL[2]);
        let side = STEP_LENGTH * FRAC_1_SQRT_2;
        let expected = Vector2::new(0.5 + side, -0.25 + side);
        assert!((moved.translation.vector - expected).norm() < 1e-15);
        assert!((moved.rotation.angle() - FRAC_PI_2 / 2.0).abs() < 1e-15);
    }

    #[test]
    fn the_heading_keeps_its_unit_length_over_a_million_actions() {
        let mut robot = Isometry2::identity();
        for turn in 0..1_000_000 {
            robot = moved(&robot, Action::ALL[turn % Action::COUNT]);
        }
        let length = robot.rotation.re * robot.rotation.re + robot.rotation.im * robot.rotation.im;
        assert!((length - 1.0).abs() < 1e-15);
    }
}
