//! The camera: what the robot sees of the world, in 20 x 7 pixels.
//!
//! A [`Camera`] looks through the stereographic [`lens`] and renders a [`Frame`] of a
//! [`crate::world::World`] by casting one ray for each pixel. The same pose gives the same bytes
//! on every machine. [`equidistant`] describes the lens to those who know only that model.

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
