//! `evac train`: a training, and the evaluation of what was learned.

use std::{path::PathBuf, process::ExitCode};

use clap::{ArgMatches, Command};

use super::{fewest_steps, nodes::Nodes, supervise};
use crate::supervision::Plan;

/// The file that a training is resumed from.
const CHECKPOINT: &str = "checkpoint.safetensors";

pub fn command() -> Command {
    Command::new("train")
        .about("Train the agent over DDS, then test it: two processes, simulator and agent")
        .after_help(
            "Ctrl-C saves the training and ends both nodes; the same command with --resume goes on.",
        )
}

pub fn run(matches: &ArgMatches, nodes: &Nodes) -> anyhow::Result<ExitCode> {
    let (agent_arguments, parameters) = nodes.agent_arguments(matches, Vec::new())?;
    let options = nodes.simulator_options(matches);
    let namespaces = match parameters.count("simulators") {
        0 | 1 => vec![String::new()],
        count => (0..count).map(|index| format!("sim{index}")).collect(),
    };
    let simulators = namespaces.iter().map(|name| nodes.simulator_arguments(name, &options));
    let simulators = simulators.collect::<anyhow::Result<Vec<_>>>()?;
    let evaluation = (parameters.count("evaluation_seed"), parameters.count("evaluation_episodes"));
    let scenario = parameters.text("scenario");
    let fewest = fewest_steps::compute(&nodes.simulator, &simulators[0], scenario, evaluation)?;
    let command = ["train".to_owned()].into_iter();
    supervise(&Plan {
        simulator: nodes.simulator.clone(),
        simulators,
        agent: nodes.agent.clone(),
        agent_arguments: command
            .chain(fewest_steps::arguments(fewest.as_ref()))
            .chain(agent_arguments)
            .collect(),
        checkpoint: Some(PathBuf::from(parameters.text("out")).join(CHECKPOINT)),
    })
}
