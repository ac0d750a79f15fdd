//! The ROS 2 node: makes the simulator available through services and topics.

mod delayed_images;
mod descriptors;
mod diagnostics;
mod messages;
mod node;
mod parameters;
mod publishers;
mod reality_parameters;
mod session;

pub use messages::StampedPose;
pub use node::run;
pub use parameters::{RoomParameters, SimulatorParameters, declare_room};
pub use session::{ClientId, Session};
