//! Lists the parameters of each command without joining a DDS domain.

use clap::ValueEnum;
use ros_runtime::{Arguments, Node, parameters::Declaration};

use super::{drive, evaluate, train};

/// A command of the node that uses DDS.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NodeCommand {
    /// Train, then evaluate
    Train,
    /// Evaluate a model
    Evaluate,
    /// Drive a robot
    Drive,
}

/// Returns the parameters of `command` with the values given by `arguments`.
///
/// # Errors
///
/// Returns an error for an invalid name, parameter file or value, for an unknown parameter, or if
/// the parameter `model` names a directory without a trained model.
pub fn parameters_of(
    command: NodeCommand,
    arguments: &Arguments,
) -> anyhow::Result<Vec<Declaration>> {
    let parameters = Node::parameters_only("agent_node", arguments)?;
    match command {
        NodeCommand::Train => train::declare_parameters(&parameters)?,
        NodeCommand::Evaluate => evaluate::declare_parameters(&parameters)?,
        NodeCommand::Drive => drive::declare_parameters(&parameters)?,
    }
    Ok(parameters.declarations())
}
