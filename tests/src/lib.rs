//! What the integration tests share: the room in this process, and the real nodes as processes.

use std::io::Write;

pub mod attacker;
mod caller;
pub mod network;
mod nodes;
mod outcome;
pub mod packets;
mod room;
mod silent;

pub use caller::assert_calls_the_services;
pub use nodes::{Nodes, PATIENCE, binary, corrected_rustdds, repository};
pub use outcome::Outcome;
pub use room::Room;
pub use silent::Silent;

/// Says that a test is skipped and why, past the harness, which keeps to itself what a test prints that
/// does not fail.
pub fn skip(reason: &str) {
    // A closed standard error fails no test.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {reason}");
}
