//! The parameters of each command, told without a DDS domain.

use clap::ValueEnum;
use ros_runtime::{Arguments, Node, parameters::Declaration};

use super::{drive, evaluate, train};

/// What the node can be started for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NodeCommand {
    /// Train, then test.
    Train,
    /// Test a model.
    Evaluate,
    /// Drive a robot.
    Drive,
}

/// The parameters of a command with the values that the arguments give them.
///
/// # Errors
///
/// What is wrong with the arguments.
pub fn parameters_of(
    command: NodeCommand,
    arguments: &Arguments,
) -> anyhow::Result<Vec<Declaration>> {
    let parameters = Node::parameters_alone("agent_node", arguments)?;
    match command {
        NodeCommand::Train => train::declare_parameters(&parameters)?,
        NodeCommand::Evaluate => evaluate::declare_parameters(&parameters)?,
        NodeCommand::Drive => drive::declare_parameters(&parameters)?,
    }
    Ok(parameters.declarations())
}
