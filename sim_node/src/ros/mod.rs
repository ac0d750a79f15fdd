//! The ROS 2 node: makes the simulator available through services and topics.

mod diagnostics;
mod messages;
mod node;
mod parameters;
mod publishers;
mod session;

pub use messages::StampedPose;
pub use node::run;
pub use parameters::{RoomParameters, SimulatorParameters, declare_room};
pub use session::{ClientId, Session};
