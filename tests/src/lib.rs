//! What the integration tests share: the room in this process, and the real nodes as processes.

mod nodes;
mod room;
mod silent;

pub use nodes::{Nodes, PATIENCE, binary, repository};
pub use room::Room;
pub use silent::Silent;
