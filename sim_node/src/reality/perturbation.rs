//! Groups of perturbations that are measured together.

use super::settings::Reality;

/// A group of perturbations, one row of the robustness table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Perturbation {
    /// Noise of the camera.
    CameraNoise,
    /// Brightness of the images.
    CameraGain,
    /// White balance of the images.
    CameraColor,
    /// Pitch, roll and yaw of the camera's mount.
    CameraAngles,
    /// Height of the camera and its field of view.
    CameraHeightAndLens,
    /// Lost images.
    CameraDrops,
    /// Direction of the light and colours of the surfaces.
    LightAndSurfaces,
    /// Random errors of turns and steps.
    MotionNoise,
    /// Systematic errors of turns and steps.
    MotionBias,
    /// Motion of the robot in blocked moves.
    BlockedMotion,
    /// Speed of the moving cylinders.
    ObstacleSpeed,
}

impl Perturbation {
    /// All groups. Latency and odometry are not among them: they do not affect what a policy sees
    /// when each image is the result of a step.
    pub const ALL: [Perturbation; 11] = [
        Perturbation::CameraNoise,
        Perturbation::CameraGain,
        Perturbation::CameraColor,
        Perturbation::CameraAngles,
        Perturbation::CameraHeightAndLens,
        Perturbation::CameraDrops,
        Perturbation::LightAndSurfaces,
        Perturbation::MotionNoise,
        Perturbation::MotionBias,
        Perturbation::BlockedMotion,
        Perturbation::ObstacleSpeed,
    ];

    /// Returns the name used in files.
    pub fn name(self) -> &'static str {
        match self {
            Perturbation::CameraNoise => "camera_noise",
            Perturbation::CameraGain => "camera_gain",
            Perturbation::CameraColor => "camera_color",
            Perturbation::CameraAngles => "camera_angles",
            Perturbation::CameraHeightAndLens => "camera_height_and_lens",
            Perturbation::CameraDrops => "camera_drops",
            Perturbation::LightAndSurfaces => "light_and_surfaces",
            Perturbation::MotionNoise => "motion_noise",
            Perturbation::MotionBias => "motion_bias",
            Perturbation::BlockedMotion => "blocked_motion",
            Perturbation::ObstacleSpeed => "obstacle_speed",
        }
    }

    /// Returns a world in which only this group is on, with its strength from `from`.
    pub fn alone(self, from: &Reality) -> Reality {
        let mut reality = Reality::default();
        let (camera, motion) = (&mut reality.camera, &mut reality.motion);
        match self {
            Perturbation::CameraNoise => camera.noise = from.camera.noise,
            Perturbation::CameraGain => camera.gain = from.camera.gain,
            Perturbation::CameraColor => camera.color = from.camera.color,
            Perturbation::CameraAngles => {
                camera.pitch = from.camera.pitch;
                camera.roll = from.camera.roll;
                camera.yaw = from.camera.yaw;
            }
            Perturbation::CameraHeightAndLens => {
                camera.height = from.camera.height;
                camera.lens = from.camera.lens;
            }
            Perturbation::CameraDrops => camera.drop_rate = from.camera.drop_rate,
            Perturbation::LightAndSurfaces => reality.surfaces = from.surfaces,
            Perturbation::MotionNoise => {
                motion.turn_noise = from.motion.turn_noise;
                motion.step_noise = from.motion.step_noise;
            }
            Perturbation::MotionBias => {
                motion.turn_bias = from.motion.turn_bias;
                motion.step_bias = from.motion.step_bias;
            }
            Perturbation::BlockedMotion => motion.blocked = from.motion.blocked,
            Perturbation::ObstacleSpeed => reality.obstacles = from.obstacles,
        }
        reality
    }
}
