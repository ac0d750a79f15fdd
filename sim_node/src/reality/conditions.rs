//! The conditions of one episode.

use task::{Action, Random, action::STEP_LENGTH};

use super::gaussian;
use super::interval::Interval;
use super::settings::{BlockedMotion, Reality};

/// The conditions of an episode: what is drawn at its start, and the strength of its noise.
///
/// The default is the world of the paper, without perturbations.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Conditions {
    /// Identifies the random numbers of the episode; 0 without perturbations.
    key: u64,
    /// The camera.
    pub camera: CameraConditions,
    /// The light.
    pub light: LightConditions,
    /// The surfaces.
    pub surfaces: SurfaceConditions,
    /// Execution of actions.
    pub motion: MotionConditions,
    /// Errors of the published odometry.
    pub odometry: OdometryConditions,
    /// The moving cylinders.
    pub obstacles: ObstacleConditions,
}

/// The moving cylinders in an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObstacleConditions {
    /// Factor for the length of a step.
    pub speed: f64,
}

impl Default for ObstacleConditions {
    fn default() -> ObstacleConditions {
        ObstacleConditions { speed: 1.0 }
    }
}

/// The camera in an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraConditions {
    /// Standard deviation of the noise, in grey levels of 255.
    pub noise: f64,
    /// Brightness factor.
    pub gain: f64,
    /// Factors for red, green and blue.
    pub color: [f64; 3],
    /// Error of the downward pitch of the mount, in radians.
    pub pitch: f64,
    /// Error of the roll of the mount, in radians; positive lowers the right side.
    pub roll: f64,
    /// Error of the yaw of the mount, in radians; positive turns the camera to the left.
    pub yaw: f64,
    /// Error of the height of the mount, in metres.
    pub height: f64,
    /// Relative error of the field of view.
    pub lens: f64,
    /// Time from exposure to publication, in seconds of real time.
    pub latency: f64,
    /// Share of images that are lost, 0 to 1.
    pub drop_rate: f64,
}

impl Default for CameraConditions {
    fn default() -> CameraConditions {
        CameraConditions {
            noise: 0.0,
            gain: 1.0,
            color: [1.0; 3],
            pitch: 0.0,
            roll: 0.0,
            yaw: 0.0,
            height: 0.0,
            lens: 0.0,
            latency: 0.0,
            drop_rate: 0.0,
        }
    }
}

/// The error of the direction of the light in an episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LightConditions {
    /// Counter-clockwise turn about the vertical axis, in radians.
    pub azimuth: f64,
    /// Increase of the elevation, in radians.
    pub elevation: f64,
}

/// The changes of the surfaces' colours in an episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceConditions {
    /// The walls of the room.
    pub wall: Tint,
    /// The exit.
    pub exit: Tint,
    /// Cylinders and concave wall.
    pub obstacle: Tint,
    /// The floor.
    pub floor: Tint,
    /// The sky.
    pub sky: Tint,
}

/// A change of a colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tint {
    /// Turn of the hue, in radians from red towards green.
    pub hue: f64,
    /// Brightness factor.
    pub brightness: f64,
}

impl Default for Tint {
    fn default() -> Tint {
        Tint { hue: 0.0, brightness: 1.0 }
    }
}

/// The execution of actions in an episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionConditions {
    /// Standard deviation of the turn, in radians.
    pub turn_noise: f64,
    /// Standard deviation of the step, relative to its length.
    pub step_noise: f64,
    /// Error of every turn, in radians.
    pub turn_bias: f64,
    /// Error of every step, relative to its length.
    pub step_bias: f64,
    /// Whether a blocked robot moves until it touches something.
    pub stops_short: bool,
}

/// The errors of the odometry in an episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OdometryConditions {
    /// Standard deviation per metre and per radian moved.
    pub noise: f64,
    /// Systematic error of distances, as a share.
    pub step_drift: f64,
    /// Systematic error of turns, as a share.
    pub turn_drift: f64,
}

/// What is drawn; the number selects the random numbers.
#[derive(Clone, Copy)]
enum Quantity {
    Camera = 1,
    Light = 2,
    Surfaces = 3,
    Motion = 4,
    Odometry = 5,
    Obstacles = 6,
    ImageNoise = 7,
    Drop = 8,
    MotionNoise = 9,
    OdometryNoise = 10,
}

impl Conditions {
    /// Draws the conditions of the episode with this key.
    pub fn draw(reality: &Reality, key: u64) -> Conditions {
        if *reality == Reality::default() {
            return Conditions::default();
        }
        let mut conditions = Conditions { key, ..Conditions::default() };
        conditions.camera = conditions.draw_camera(reality);
        conditions.draw_surroundings(reality);
        conditions.motion = conditions.draw_motion(reality);
        conditions
    }

    fn draw_camera(&self, reality: &Reality) -> CameraConditions {
        let camera = &reality.camera;
        let mut random = self.random(Quantity::Camera, 0);
        let mut draw = |interval: Interval| interval.draw(&mut random);
        CameraConditions {
            noise: camera.noise,
            gain: draw(camera.gain),
            color: [draw(camera.color), draw(camera.color), draw(camera.color)],
            pitch: draw(camera.pitch).to_radians(),
            roll: draw(camera.roll).to_radians(),
            yaw: draw(camera.yaw).to_radians(),
            height: draw(camera.height),
            lens: draw(camera.lens),
            latency: camera.latency,
            drop_rate: camera.drop_rate,
        }
    }

    fn draw_surroundings(&mut self, reality: &Reality) {
        let mut random = self.random(Quantity::Light, 0);
        let mut angle = || reality.surfaces.light_direction.draw(&mut random).to_radians();
        self.light = LightConditions { azimuth: angle(), elevation: angle() };
        let mut random = self.random(Quantity::Surfaces, 0);
        let mut tint = || Tint {
            hue: reality.surfaces.color.draw(&mut random) * std::f64::consts::PI,
            brightness: 1.0 + reality.surfaces.color.draw(&mut random),
        };
        self.surfaces = SurfaceConditions {
            wall: tint(),
            exit: tint(),
            obstacle: tint(),
            floor: tint(),
            sky: tint(),
        };
        let mut random = self.random(Quantity::Obstacles, 0);
        self.obstacles = ObstacleConditions { speed: reality.obstacles.speed.draw(&mut random) };
        let mut random = self.random(Quantity::Odometry, 0);
        let mut signed = || if random.chance(0.5) { 1.0 } else { -1.0 };
        self.odometry = OdometryConditions {
            noise: reality.odometry.noise,
            step_drift: signed() * reality.odometry.drift,
            turn_drift: signed() * reality.odometry.drift,
        };
    }

    fn draw_motion(&self, reality: &Reality) -> MotionConditions {
        let motion = &reality.motion;
        let mut random = self.random(Quantity::Motion, 0);
        MotionConditions {
            turn_noise: motion.turn_noise.to_radians(),
            step_noise: motion.step_noise,
            turn_bias: random.within(motion.turn_bias).to_radians(),
            step_bias: random.within(motion.step_bias),
            stops_short: match motion.blocked {
                BlockedMotion::Stay => false,
                BlockedMotion::StopShort => true,
                BlockedMotion::Mixed => random.chance(0.5),
            },
        }
    }

    /// Returns the random numbers of a quantity. `number` distinguishes steps and images.
    fn random(&self, quantity: Quantity, number: u64) -> Random {
        Random::from_key([self.key, quantity as u64, 0, 0]).with_stream(number)
    }

    /// Returns the turn, in radians, and the distance, in metres, that the robot attempts for an
    /// action. `step` is the number of the step in the episode. The distance is at least 0.
    pub fn motion(&self, action: Action, step: u32) -> (f64, f64) {
        let motion = &self.motion;
        let (mut turn_noise, mut step_noise) = (0.0, 0.0);
        if motion.turn_noise > 0.0 || motion.step_noise > 0.0 {
            let mut random = self.random(Quantity::MotionNoise, u64::from(step));
            turn_noise = random.normal(motion.turn_noise);
            step_noise = random.normal(motion.step_noise);
        }
        let share = (1.0 + motion.step_bias + step_noise).max(0.0);
        (action.turn() + motion.turn_bias + turn_noise, STEP_LENGTH * share)
    }

    /// Returns whether an image is lost. `frame` is 0 for the image of the step, and counts the
    /// images that are published again before the next step.
    pub fn is_dropped(&self, step: u32, frame: u32) -> bool {
        let rate = self.camera.drop_rate;
        rate > 0.0 && self.random(Quantity::Drop, image(step, frame)).chance(rate)
    }

    /// Applies brightness, white balance and noise to an image of RGB pixels. `step` and `frame`
    /// select the noise, as in [`is_dropped`](Self::is_dropped).
    pub fn expose(&self, bytes: &mut [u8], step: u32, frame: u32) {
        let CameraConditions { noise, gain, color, .. } = self.camera;
        let factors = color.map(|factor| (gain * factor) as f32);
        if noise == 0.0 && factors == [1.0; 3] {
            return;
        }
        const CHUNK: usize = 60;
        let mut random = self.random(Quantity::ImageNoise, image(step, frame));
        for bytes in bytes.chunks_mut(CHUNK) {
            let mut values = [0.0; CHUNK];
            let values = &mut values[..bytes.len()];
            for (value, (byte, factor)) in
                values.iter_mut().zip(bytes.iter().zip(factors.iter().cycle()))
            {
                *value = f32::from(*byte) * factor;
            }
            if noise > 0.0 {
                gaussian::add_noise(values, noise as f32, &mut random);
            }
            for (byte, value) in bytes.iter_mut().zip(values) {
                // The conversion saturates at 0 and 255.
                *byte = (*value + 0.5) as u8;
            }
        }
    }

    /// Returns the errors of the odometry over a turn, in radians, and a distance, in metres.
    pub(super) fn odometry_error(&self, turn: f64, distance: f64, step: u32) -> (f64, f64) {
        let odometry = &self.odometry;
        let mut random = self.random(Quantity::OdometryNoise, u64::from(step));
        (
            odometry.turn_drift * turn + random.normal(odometry.noise * turn.abs()),
            odometry.step_drift * distance + random.normal(odometry.noise * distance),
        )
    }
}

/// Returns a number that identifies an image of an episode.
fn image(step: u32, frame: u32) -> u64 {
    u64::from(step) << 32 | u64::from(frame)
}
