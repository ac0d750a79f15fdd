//! The camera on the robot: renders the world as images of 20 x 7 pixels.
//!
//! A [`Camera`] renders a [`Frame`] of a [`crate::world::World`] through the stereographic
//! [`lens`], with one ray per pixel. The same world gives the same bytes on every machine.
//! [`equidistant`] approximates the lens with the distortion model of the same name, for
//! sensor_msgs/CameraInfo.
//!
//! # Examples
//!
//! ```
//! use sim_node::{
//!     camera::{Camera, CameraSettings, Frame, HEIGHT, WIDTH},
//!     world::{World, WorldSettings},
//! };
//! use task::Scenario;
//!
//! let world = World::new(WorldSettings::default(), Scenario::Empty, 1)?;
//! let camera = Camera::new(CameraSettings::default())?;
//! let frame = camera.render(&world);
//! assert_eq!((WIDTH, HEIGHT, frame.bytes().len()), (20, 7, Frame::LENGTH));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod equidistant;
mod frame;
pub mod lens;
pub(crate) mod light;
mod ray_fan;
mod renderer;
mod settings;
#[cfg(test)]
mod tests;

pub use frame::{CHANNELS, Frame, HEIGHT, WIDTH};
pub use renderer::Camera;
pub use settings::{CameraSettings, CameraSettingsError};
