//! The node: the room over DDS, what the node publishes, and its commands.

pub mod commands;
mod console;
pub mod conversation;
mod diagnostics;
pub mod drive;
mod escapes;
mod ground_truth;
mod parameters;
mod publishers;
mod simulator;

pub use conversation::image;
pub use parameters::TrainedModel;
pub use simulator::Simulator;

/// The name of something of a simulator's, which stands in a namespace relative to the node's own;
/// empty for that one.
fn name_in(namespace: &str, name: &str) -> String {
    match namespace {
        "" => name.to_owned(),
        namespace => format!("{namespace}/{name}"),
    }
}
