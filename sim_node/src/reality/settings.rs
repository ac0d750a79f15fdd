//! The strength of each perturbation.

use std::fmt;
use std::str::FromStr;

use task::names::{UnknownName, find};

use super::interval::Interval;

/// The strength of every perturbation. An interval gives a value that is drawn once per episode.
///
/// The default is the world of the paper: everything is off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reality {
    /// The camera.
    pub camera: CameraReality,
    /// Light and surfaces.
    pub surfaces: SurfaceReality,
    /// Execution of actions.
    pub motion: MotionReality,
    /// Errors of the published odometry.
    pub odometry: OdometryReality,
    /// Moving cylinders.
    pub obstacles: ObstacleReality,
}

/// Perturbations of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraReality {
    /// Standard deviation of the noise on each channel of each pixel, in grey levels, on a scale of
    /// 0 to 255.
    pub noise: f64,
    /// Brightness factor.
    pub gain: Interval,
    /// Factor for each colour channel (white balance).
    pub color: Interval,
    /// Error of the downward pitch of the mount, in degrees.
    pub pitch: Interval,
    /// Error of the roll of the mount, in degrees.
    pub roll: Interval,
    /// Error of the yaw of the mount, in degrees.
    pub yaw: Interval,
    /// Error of the height of the mount, in metres.
    pub height: Interval,
    /// Relative error of the field of view.
    pub lens: Interval,
    /// Time from exposure to publication, in seconds of real time.
    pub latency: f64,
    /// Share of images that are lost, 0 to 1.
    pub drop_rate: f64,
}

impl Default for CameraReality {
    fn default() -> CameraReality {
        const NONE: Interval = Interval::only(0.0);
        CameraReality {
            noise: 0.0,
            gain: Interval::only(1.0),
            color: Interval::only(1.0),
            pitch: NONE,
            roll: NONE,
            yaw: NONE,
            height: NONE,
            lens: NONE,
            latency: 0.0,
            drop_rate: 0.0,
        }
    }
}

/// Perturbations of the light and the surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceReality {
    /// Error of the azimuth and of the elevation of the light, in degrees.
    pub light_direction: Interval,
    /// Change of the colour of each kind of surface: its hue turns by up to this share of 180
    /// degrees, and its brightness changes by up to this share.
    pub color: Interval,
}

impl Default for SurfaceReality {
    fn default() -> SurfaceReality {
        SurfaceReality { light_direction: Interval::only(0.0), color: Interval::only(0.0) }
    }
}

/// Perturbations of the execution of actions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionReality {
    /// Standard deviation of the turn, in degrees.
    pub turn_noise: f64,
    /// Standard deviation of the step, relative to its length.
    pub step_noise: f64,
    /// Largest error of all turns of an episode, in degrees; each episode draws its error uniformly.
    pub turn_bias: f64,
    /// Largest error of all steps of an episode, relative to their length; drawn likewise.
    pub step_bias: f64,
    /// What a blocked move does.
    pub blocked: BlockedMotion,
}

impl Default for MotionReality {
    fn default() -> MotionReality {
        MotionReality {
            turn_noise: 0.0,
            step_noise: 0.0,
            turn_bias: 0.0,
            step_bias: 0.0,
            blocked: BlockedMotion::Stay,
        }
    }
}

/// Errors of the published odometry.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OdometryReality {
    /// Standard deviation per metre and per radian moved.
    pub noise: f64,
    /// Systematic error, as a share of the distance and of the turn. Its signs are drawn once per
    /// episode.
    pub drift: f64,
}

/// Perturbations of the moving cylinders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObstacleReality {
    /// Factor for the length of a cylinder's step.
    pub speed: Interval,
}

impl Default for ObstacleReality {
    fn default() -> ObstacleReality {
        ObstacleReality { speed: Interval::only(1.0) }
    }
}

impl Reality {
    /// Returns the strengths of a named level.
    pub fn of(level: Randomization) -> Reality {
        const fn around(half_width: f64) -> Interval {
            Interval::around_zero(half_width)
        }
        let between = Interval::between;
        match level {
            Randomization::None => Reality::default(),
            Randomization::Mild => Reality {
                camera: CameraReality {
                    noise: 3.0,
                    gain: between(0.8, 1.25),
                    color: between(0.9, 1.1),
                    pitch: around(1.0),
                    roll: around(1.0),
                    yaw: around(1.0),
                    height: around(0.01),
                    lens: around(0.02),
                    latency: 0.02,
                    drop_rate: 0.0,
                },
                surfaces: SurfaceReality { light_direction: around(20.0), color: around(0.05) },
                motion: MotionReality {
                    turn_noise: 2.0,
                    step_noise: 0.02,
                    turn_bias: 1.0,
                    step_bias: 0.02,
                    blocked: BlockedMotion::Stay,
                },
                odometry: OdometryReality { noise: 0.01, drift: 0.005 },
                obstacles: ObstacleReality { speed: between(0.8, 1.2) },
            },
            Randomization::Strong => Reality {
                camera: CameraReality {
                    noise: 10.0,
                    gain: between(0.6, 1.5),
                    color: between(0.75, 1.3),
                    pitch: around(3.0),
                    roll: around(3.0),
                    yaw: around(3.0),
                    height: around(0.03),
                    lens: around(0.05),
                    latency: 0.1,
                    drop_rate: 0.05,
                },
                surfaces: SurfaceReality { light_direction: around(60.0), color: around(0.15) },
                motion: MotionReality {
                    turn_noise: 6.0,
                    step_noise: 0.08,
                    turn_bias: 4.0,
                    step_bias: 0.08,
                    blocked: BlockedMotion::Mixed,
                },
                odometry: OdometryReality { noise: 0.05, drift: 0.02 },
                obstacles: ObstacleReality { speed: between(0.3, 2.0) },
            },
        }
    }
}

/// A named level of all perturbations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Randomization {
    /// No perturbations: the world of the paper.
    None,
    /// A good camera on a well-calibrated robot.
    Mild,
    /// A cheap camera on a robot with slipping wheels, under changing light.
    Strong,
}

impl Randomization {
    /// All levels, in ascending order.
    pub const ALL: [Randomization; 3] =
        [Randomization::None, Randomization::Mild, Randomization::Strong];

    /// Returns the level that consists of these perturbations, if there is one.
    pub fn matching(reality: &Reality) -> Option<Randomization> {
        Self::ALL.into_iter().find(|level| Reality::of(*level) == *reality)
    }

    /// Returns the name used in parameters and files.
    pub fn name(self) -> &'static str {
        match self {
            Randomization::None => "none",
            Randomization::Mild => "mild",
            Randomization::Strong => "strong",
        }
    }
}

impl fmt::Display for Randomization {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for Randomization {
    type Err = UnknownName;

    /// Parses the name of a level.
    ///
    /// # Errors
    ///
    /// Returns an error if no level has this name.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        find("randomization", Self::ALL, name)
    }
}

/// What a blocked move does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BlockedMotion {
    /// The robot keeps its position and heading, as in the paper.
    Stay,
    /// The robot turns as far as it can and then advances until it touches something, as wheels do.
    StopShort,
    /// Each episode draws one of the two, with equal probability.
    Mixed,
}

impl BlockedMotion {
    /// All values.
    pub const ALL: [BlockedMotion; 3] =
        [BlockedMotion::Stay, BlockedMotion::StopShort, BlockedMotion::Mixed];

    /// Returns the name used in parameters and files.
    pub fn name(self) -> &'static str {
        match self {
            BlockedMotion::Stay => "stay",
            BlockedMotion::StopShort => "stop_short",
            BlockedMotion::Mixed => "mixed",
        }
    }
}

impl fmt::Display for BlockedMotion {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for BlockedMotion {
    type Err = UnknownName;

    /// Parses a name.
    ///
    /// # Errors
    ///
    /// Returns an error if no value has this name.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        find("blocked motion", Self::ALL, name)
    }
}
