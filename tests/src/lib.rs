//! What the integration tests share: the room in this process, and the real nodes as processes.

pub mod attacker;
mod caller;
mod interruption;
pub mod network;
mod nodes;
mod outcome;
pub mod packets;
mod room;
mod silent;

pub use caller::{assert_calls_the_services, fast_dds_peer};
pub use interruption::assert_survives;
pub use nodes::{Nodes, PATIENCE, binary, repository};
pub use outcome::Outcome;
pub use room::Room;
pub use silent::Silent;

/// What all types that cross the wire look like.
pub fn interfaces() -> ros_interfaces::Interfaces {
    ros_interfaces::Interfaces::with(evac_msgs::DEFINITIONS)
        .expect("the definitions are well-formed")
}
