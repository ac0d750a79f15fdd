//! The mount of the camera on the robot.

use std::f64::consts::FRAC_PI_2;

use crate::world::{CONCAVE_WALL_HEIGHT, FOOTPRINT_SIDE};

/// The mount of the camera, relative to the centre of the robot's footprint on the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSettings {
    /// Distance ahead of the robot's centre in metres, within ±0.075 (the footprint).
    pub forward: f64,
    /// Distance to the left of the robot's centre in metres, within ±0.075 (the footprint).
    pub left: f64,
    /// Height above the floor in metres, above 0 and below 0.25. The lowest obstacle is 0.25 m
    /// tall, so the camera never sees the top of an obstacle.
    pub height: f64,
    /// Downward pitch in radians, a rotation about the y axis, within ±π/2.
    pub pitch: f64,
}

impl Default for CameraSettings {
    /// Returns a level camera in the middle of the robot's front face, 0.09 m above the floor, as
    /// in the paper authors' public robot model.
    fn default() -> Self {
        Self { forward: FOOTPRINT_SIDE / 2.0, left: 0.0, height: 0.09, pitch: 0.0 }
    }
}

/// The error for an invalid camera mount.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CameraSettingsError {
    /// The camera would be below the floor or could see the top of an obstacle. Holds the height in
    /// metres.
    #[error(
        "camera height: invalid value {0} m (expected: above 0 and below {CONCAVE_WALL_HEIGHT} m, \
         the height of the lowest obstacle)"
    )]
    Height(f64),
    /// The camera would protrude from the robot and could be inside an obstacle.
    #[error(
        "camera position: invalid value ({forward}, {left}) m (expected: within ±{} m of the \
         robot's centre on both axes)", FOOTPRINT_SIDE / 2.0
    )]
    OffRobot {
        /// Distance ahead of the robot's centre, in metres.
        forward: f64,
        /// Distance to the left of the robot's centre, in metres.
        left: f64,
    },
    /// The camera would look backwards. Holds the pitch in radians.
    #[error("camera pitch: invalid value {0} rad (expected: within ±π/2, positive is downward)")]
    Pitch(f64),
}

impl CameraSettings {
    /// Checks the ranges of all fields; NaN is invalid.
    pub(super) fn check(&self) -> Result<(), CameraSettingsError> {
        let footprint = -FOOTPRINT_SIDE / 2.0..=FOOTPRINT_SIDE / 2.0;
        let &Self { forward, left, height, pitch } = self;
        if !(height > 0.0 && height < CONCAVE_WALL_HEIGHT) {
            Err(CameraSettingsError::Height(height))
        } else if !(footprint.contains(&forward) && footprint.contains(&left)) {
            Err(CameraSettingsError::OffRobot { forward, left })
        } else if !(-FRAC_PI_2..=FRAC_PI_2).contains(&pitch) {
            Err(CameraSettingsError::Pitch(pitch))
        } else {
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_a_mount_outside_the_robot_or_above_the_lowest_obstacle() {
        let default = CameraSettings::default();
        assert_eq!(default.check(), Ok(()));
        for (settings, message) in [
            (
                CameraSettings { height: 0.3, ..default },
                "camera height: invalid value 0.3 m (expected: above 0 and below 0.25 m, the \
                 height of the lowest obstacle)",
            ),
            (
                CameraSettings { forward: 0.1, ..default },
                "camera position: invalid value (0.1, 0) m (expected: within ±0.075 m of the \
                 robot's centre on both axes)",
            ),
            (
                CameraSettings { pitch: 2.0, ..default },
                "camera pitch: invalid value 2 rad (expected: within ±π/2, positive is downward)",
            ),
        ] {
            assert_eq!(settings.check().unwrap_err().to_string(), message);
        }
        assert!(CameraSettings { height: f64::NAN, ..default }.check().is_err());
        assert!(CameraSettings { left: f64::NAN, ..default }.check().is_err());
        assert!(CameraSettings { pitch: f64::NAN, ..default }.check().is_err());
    }
}
