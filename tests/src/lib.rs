//! The harness of the integration tests, including the part it shares with the crate `experiments`.

pub mod attacker;
mod caller;
mod interruption;
pub mod launcher;
pub mod packets;

pub use caller::{assert_calls_the_services, fast_dds_peer};
pub use experiments::{Nodes, NullListener, Outcome, Room, TIMEOUT, binary, network, repository};
pub use interruption::assert_survives;

/// Returns the definitions of all message and service types on the wire.
///
/// # Panics
///
/// Panics if a definition is invalid.
pub fn interfaces() -> ros_interfaces::Interfaces {
    ros_interfaces::Interfaces::with(evac_msgs::DEFINITIONS).expect("valid definitions")
}
