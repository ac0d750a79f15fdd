//! The node: the room over DDS, what the node publishes, and its commands.

mod announcer;
mod common;
mod console;
pub mod conversation;
mod diagnostics;
pub mod drive;
mod escapes;
pub mod evaluate;
mod ground_truth;
mod parameters;
mod parameters_of;
mod policy_test;
mod publishers;
mod simulator;
mod simulator_error;
pub mod train;
mod training_listener;

pub use conversation::image;
pub use parameters::TrainedModel;
pub use parameters_of::{NodeCommand, parameters_of};
pub use simulator::Simulator;
pub use simulator_error::SimulatorError;

/// The name of something of a simulator's, which stands in a namespace relative to the node's own;
/// empty for that one.
fn name_in(namespace: &str, name: &str) -> String {
    match namespace {
        "" => name.to_owned(),
        namespace => format!("{namespace}/{name}"),
    }
}
