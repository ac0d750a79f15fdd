//! The harness that the integration tests and the measurement programs share: an environment in
//! this process ([`Room`]), the real nodes as child processes ([`Nodes`]), and an emulated
//! unreliable network between them ([`network`]).
//!
//! The programs of this package are `benchmark`, `ablation`, `reproduction`, `camera_limit` and `soak`; `evac` runs
//! them as `evac bench`, `evac ablation`, `evac reproduce`, `evac camera-limit` and `evac soak`.

pub mod network;
mod nodes;
mod null_listener;
mod outcome;
pub mod reproduction;
mod room;
mod section;
pub mod study;

pub use nodes::{Nodes, TIMEOUT, binary, repository};
pub use null_listener::NullListener;
pub use outcome::Outcome;
pub use room::{Room, RoomError};
pub use section::replace_section;
