//! Odometry: the pose that a robot computes from the rotation of its wheels.

use nalgebra::{Isometry2, Matrix3, Matrix3x2, UnitComplex, Vector2, Vector3};

use super::conditions::{Conditions, OdometryConditions};

/// The pose that the robot believes to have, and its uncertainty.
///
/// Without errors, it is the true pose to the last bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Odometry {
    /// Estimated pose, in metres and radians.
    pub pose: Isometry2<f64>,
    /// Covariance of x, y and heading due to noise, in metres and radians.
    noise: Matrix3<f64>,
    /// Derivatives of x, y and heading with respect to the systematic errors of turns and of
    /// distances.
    drift: Matrix3x2<f64>,
    /// Standard deviation of each of the two systematic errors.
    drift_deviation: f64,
}

impl Odometry {
    /// Returns the odometry at the start of an episode, which is exact.
    pub fn at(pose: Isometry2<f64>) -> Odometry {
        Odometry { pose, noise: Matrix3::zeros(), drift: Matrix3x2::zeros(), drift_deviation: 0.0 }
    }

    /// Returns the covariance of x, y and heading, in metres and radians, to first order in the
    /// errors.
    pub fn covariance(&self) -> Matrix3<f64> {
        let drift = self.drift * self.drift_deviation;
        self.noise + drift * drift.transpose()
    }

    /// Follows the robot from one true pose to the next. `step` is the number of the step.
    pub(crate) fn follow(
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
        let distance = (to.translation.vector - from.translation.vector).norm();
        let (turn_error, step_error) = conditions.odometry_error(turn, distance, step);
        self.pose.append_rotation_wrt_center_mut(&UnitComplex::new(turn + turn_error));
        self.pose.rotation.renormalize();
        let along = self.pose.rotation * Vector2::new(1.0, 0.0);
        self.pose.translation.vector += along * (distance + step_error);

        // The derivatives of the new pose with respect to the old pose, the turn and the distance.
        // An error of the heading before the move shifts its end sideways.
        let sideways = distance * Vector2::new(-along.y, along.x);
        let mut transition = Matrix3::identity();
        transition.fixed_view_mut::<2, 1>(0, 2).copy_from(&sideways);
        let by_turn = Vector3::new(sideways.x, sideways.y, 1.0);
        let by_distance = Vector3::new(along.x, along.y, 0.0);
        let noise = conditions.odometry.noise;
        let (by_turn, by_distance) = (by_turn * turn, by_distance * distance);
        self.noise = transition * self.noise * transition.transpose()
            + noise * noise * by_turn * by_turn.transpose()
            + noise * noise * by_distance * by_distance.transpose();
        self.drift = transition * self.drift + Matrix3x2::from_columns(&[by_turn, by_distance]);
        self.drift_deviation = conditions.odometry.turn_drift.abs();
    }
}
