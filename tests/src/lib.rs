//! What the integration tests share, that of the crate `experiments` included.

pub mod attacker;
mod caller;
mod interruption;
pub mod launcher;
pub mod packets;

pub use caller::{assert_calls_the_services, fast_dds_peer};
pub use experiments::{Nodes, Outcome, PATIENCE, Room, Silent, binary, network, repository};
pub use interruption::assert_survives;

/// What all types that cross the wire look like.
pub fn interfaces() -> ros_interfaces::Interfaces {
    ros_interfaces::Interfaces::with(evac_msgs::DEFINITIONS)
        .expect("the definitions are well-formed")
}
