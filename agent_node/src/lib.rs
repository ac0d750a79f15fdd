//! The agent node: trains, evaluates and deploys a deep Dyna-Q agent over ROS 2.
//!
//! The crate [`learning`] implements the learning method. This crate connects it to DDS: [`ros`]
//! contains an [`Environment`](task::Environment) backed by a simulator, the publishers and the
//! node's commands; [`background`] runs an environment on its own thread, so that requests overlap
//! with network updates.

pub mod background;
pub mod ros;
