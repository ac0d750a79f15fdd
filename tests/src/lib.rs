//! What the integration tests share: the room in this process, and the real nodes as processes.

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
