//! The brain: a ROS 2 node that learns by deep Dyna-Q to drive a robot out of a room.
//!
//! The method is the crate [`learning`]. Here is what brings it to DDS: [`ros`] has the room over DDS as
//! an [`Environment`](task::Environment), what the node publishes, and its commands; [`background`]
//! lets the learner learn while another thread speaks with the room.

pub mod background;
pub mod ros;
