//! What tests and measurements share: the room in this process, the real nodes as processes, and bad
//! networks between them. The programs of this package measure: `benchmark`, `ablation`, `reproduction`
//! and `soak`; `evac` starts them.

pub mod network;
mod nodes;
mod outcome;
pub mod reproduction;
mod room;
mod section;
mod silent;

pub use nodes::{Nodes, PATIENCE, binary, repository};
pub use outcome::Outcome;
pub use room::{Room, RoomError};
pub use section::replace_section;
pub use silent::Silent;
