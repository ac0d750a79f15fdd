//! Odometry: the pose that a robot computes from the rotation of its wheels.

use nalgebra::{Isometry2, UnitComplex, Vector2};

use super::conditions::{Conditions, OdometryConditions};

/// The pose that the robot believes to have, and its uncertainty.
///
/// Without errors, it is the true pose to the last bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Odometry {
    /// Estimated pose, in metres and radians.
    pub pose: Isometry2<f64>,
    /// Variance of x and of y, in square metres. The correlation with the heading is neglected.
    pub position_variance: f64,
    /// Variance of the heading, in square radians.
    pub heading_variance: f64,
}

impl Odometry {
    /// Returns the odometry at the start of an episode, which is exact.
    pub fn at(pose: Isometry2<f64>) -> Odometry {
        Odometry { pose, position_variance: 0.0, heading_variance: 0.0 }
    }

    /// Follows the robot from one true pose to the next. `step` is the number of the step.
    pub fn follow(
        &mut self,
        from: &Isometry2<f64>,
        to: &Isometry2<f64>,
        conditions: &Conditions,
        step: u32,
    ) {
        if conditions.odometry == OdometryConditions::default() {
            self.pose = *to;
            return;
        }
        // The robot turns first and then moves straight ahead.
        let turn = from.rotation.rotation_to(&to.rotation).angle();
        let moved = to.translation.vector - from.translation.vector;
        let distance = moved.norm();
        let (turn_error, step_error) = conditions.odometry_error(turn, distance, step);
        self.pose.append_rotation_wrt_center_mut(&UnitComplex::new(turn + turn_error));
        self.pose.rotation.renormalize();
        let along = Vector2::new(distance + step_error, 0.0);
        self.pose.translation.vector += self.pose.rotation * along;
        let square = |deviation: f64| deviation * deviation;
        let noise = conditions.odometry.noise;
        self.heading_variance += square(noise * turn);
        self.position_variance += square(noise * distance);
    }
}
