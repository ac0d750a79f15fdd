//! What a real robot adds to the world of the paper: an imperfect camera, light, motion and odometry.
//!
//! [`Reality`] holds the strength of each perturbation; all are off by default. At the start of an
//! episode, [`Conditions::draw`] draws what stays the same during the episode, such as the
//! brightness. Noise is drawn for each step and image.
//!
//! Every perturbation is a function of the episode key, the step index and the image index alone (see
//! [`task::Random`]). Each quantity has its own random stream, so switching one
//! perturbation on or off does not change the others.
//!
//! # Examples
//!
//! ```
//! use sim_node::reality::{Conditions, Randomization, Reality};
//!
//! let reality = Reality::of(Randomization::Mild);
//! let conditions = Conditions::draw(&reality, 7);
//! assert!((0.8..1.25).contains(&conditions.camera.gain));
//! assert_eq!(conditions, Conditions::draw(&reality, 7));
//! assert_eq!(Conditions::draw(&Reality::default(), 7), Conditions::default());
//! ```

mod conditions;
mod gaussian;
mod interval;
mod odometry;
mod settings;
#[cfg(test)]
mod tests;

pub use conditions::{
    CameraConditions, Conditions, LightConditions, MotionConditions, ObstacleConditions,
    OdometryConditions, SurfaceConditions, Tint,
};
pub use interval::{Interval, IntervalError};
pub use odometry::Odometry;
pub use settings::{
    BlockedMotion, CameraReality, MotionReality, ObstacleReality, OdometryReality, Randomization,
    Reality, SurfaceReality,
};
