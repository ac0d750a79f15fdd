//! The ROS side of the node: the simulator as an [`Environment`](task::Environment), and the
//! publishers, parameters and commands `train`, `evaluate` and `drive`.

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
mod policy_evaluation;
mod publishers;
mod robustness;
mod simulator;
mod simulator_error;
pub mod train;
mod training_listener;

pub use conversation::image;
pub use parameters::TrainedModel;
pub use parameters_of::{NodeCommand, parameters_of};
pub use simulator::Simulator;
pub use simulator_error::SimulatorError;

/// Returns the name of a topic, service or node of the simulator in `namespace`. Both `namespace`
/// and the result are relative to the namespace of this node; an empty `namespace` means the same
/// namespace.
fn name_in(namespace: &str, name: &str) -> String {
    match namespace {
        "" => name.to_owned(),
        namespace => format!("{namespace}/{name}"),
    }
}
