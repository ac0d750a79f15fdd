//! The brain: a ROS 2 node that learns by deep Dyna-Q to drive a robot out of a room.
//!
//! - [`learning`] is the paper: networks, memory, exploration, the training loop. It knows no ROS.
//! - [`environment`] is the trait that training and evaluation speak to.
//! - [`background`] lets the learner learn while another thread speaks with the environment.
//! - [`ros`] is the room over DDS as such an environment, and what the node publishes.
//! - [`run`] is a directory with what a training leaves behind, whole files only.
//! - [`saver`] writes it while the training goes on.
//! - [`report`] makes a page of it that one likes to open.

pub mod background;
pub mod environment;
pub mod learning;
pub mod report;
pub mod ros;
pub mod run;
pub mod saver;
