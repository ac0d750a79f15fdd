//! The node: the room behind services and topics.

mod diagnostics;
mod messages;
mod node;
mod parameters;
mod publishers;
mod session;

pub use node::run;
pub use parameters::{RoomParameters, SimulatorParameters, declare_room};
pub use session::{ClientId, Session, Visit};
