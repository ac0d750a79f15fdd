//! Where the camera is on the robot.

use std::f64::consts::FRAC_PI_2;

use crate::world::{CONCAVE_WALL_HEIGHT, FOOTPRINT_SIDE};

/// The mount of the camera on the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSettings {
    /// How far the camera is ahead of the robot's centre, in metres: within the footprint,
    /// ±0.075.
    pub forward: f64,
    /// How far it is to the left of the robot's centre, in metres: within the footprint, ±0.075.
    pub left: f64,
    /// How far it is above the floor, in metres: between 0 and 0.25, the height of the lowest
    /// obstacle, so that it never sees anything from above.
    pub height: f64,
    /// How far it looks down, in radians: a rotation about the y axis, within ±π/2.
    pub pitch: f64,
}

impl Default for CameraSettings {
    /// The middle of the robot's front face, at the height that the authors' public robot model
    /// has, level.
    fn default() -> Self {
        Self { forward: FOOTPRINT_SIDE / 2.0, left: 0.0, height: 0.09, pitch: 0.0 }
    }
}

/// Why a camera cannot be mounted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CameraSettingsError {
    /// The camera would be in the floor, or could look at an obstacle's top.
    #[error(
        "a camera at a height of {0} m cannot be: it is above 0 and below {CONCAVE_WALL_HEIGHT} m, \
         the height of the lowest obstacle"
    )]
    Height(f64),
    /// The camera would stick out of the robot, and into whatever the robot may come close to.
    #[error(
        "a camera {forward} m ahead and {left} m to the left of the robot's centre is off the \
         robot: both are within ±{} m", FOOTPRINT_SIDE / 2.0
    )]
    OffRobot {
        /// How far ahead, in metres.
        forward: f64,
        /// How far to the left, in metres.
        left: f64,
    },
    /// The camera would look backwards.
    #[error("a camera cannot be pitched by {0} rad: the pitch is within ±π/2, downwards positive")]
    Pitch(f64),
}

impl CameraSettings {
    /// Whether a camera can be mounted like this.
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
    fn only_mounts_on_the_robot_and_below_the_obstacles_are_possible() {
        let default = CameraSettings::default();
        assert_eq!(default.check(), Ok(()));
        for (settings, message) in [
            (
                CameraSettings { height: 0.3, ..default },
                "a camera at a height of 0.3 m cannot be: it is above 0 and below 0.25 m, the \
                 height of the lowest obstacle",
            ),
            (
                CameraSettings { forward: 0.1, ..default },
                "a camera 0.1 m ahead and 0 m to the left of the robot's centre is off the robot: \
                 both are within ±0.075 m",
            ),
            (
                CameraSettings { pitch: 2.0, ..default },
                "a camera cannot be pitched by 2 rad: the pitch is within ±π/2, downwards positive",
            ),
        ] {
            assert_eq!(settings.check().unwrap_err().to_string(), message);
        }
        assert!(CameraSettings { height: f64::NAN, ..default }.check().is_err());
        assert!(CameraSettings { left: f64::NAN, ..default }.check().is_err());
        assert!(CameraSettings { pitch: f64::NAN, ..default }.check().is_err());
    }
}
