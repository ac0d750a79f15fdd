//! What the integration tests share: the room in this process, and the real nodes as processes.

mod nodes;
mod room;

pub use nodes::{Nodes, PATIENCE, binary, repository};
pub use room::Room;
