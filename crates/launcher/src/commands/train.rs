//! `evac train`: trains a policy, then evaluates it.

use std::{path::PathBuf, process::ExitCode};

use clap::{ArgMatches, Command};

use super::{
    nodes::{Nodes, RANDOMIZATION, ROBUST_RANDOMIZATION},
    shortest_paths,
};
use crate::supervision::{Plan, supervise};

/// The file from which a training run resumes, in the directory that the parameter `out` specifies.
const CHECKPOINT: &str = "checkpoint.safetensors";

pub fn command() -> Command {
    Command::new("train")
        .about("Train a policy over DDS (simulator and agent are separate processes), then evaluate it")
        .after_help(
            "Preset robust trains with domain randomization: --randomization is strong unless \
             given. With preset paper, it is none unless given. The evaluation after the training \
             run has the same randomization.\n\n\
             Ctrl-C saves a checkpoint and stops all nodes. The same command with --resume \
             continues the training run.",
        )
}

pub fn run(matches: &ArgMatches, nodes: &Nodes) -> anyhow::Result<ExitCode> {
    let (agent_arguments, parameters) = nodes.agent_arguments(matches, Vec::new())?;
    let mut options = Vec::new();
    if parameters.text("preset") == "robust" {
        // The first option: those on the command line take precedence.
        options.extend(["-p".to_owned(), format!("{RANDOMIZATION}:={ROBUST_RANDOMIZATION}")]);
    }
    options.extend(nodes.simulator_options(matches));
    let namespaces = match parameters.count("simulators") {
        0 | 1 => vec![String::new()],
        count => (0..count).map(|index| format!("sim{index}")).collect(),
    };
    let simulators = namespaces.iter().map(|name| nodes.simulator_arguments(name, &options));
    let simulators = simulators.collect::<anyhow::Result<Vec<_>>>()?;
    let evaluation = (parameters.count("evaluation_seed"), parameters.count("evaluation_episodes"));
    let scenario = parameters.text("scenario");
    let shortest = shortest_paths::compute(&nodes.simulator, &simulators[0], scenario, evaluation)?;
    let command = ["train".to_owned()].into_iter();
    supervise(&Plan {
        simulator: nodes.simulator.clone(),
        simulators,
        agent: nodes.agent.clone(),
        agent_arguments: command
            .chain(shortest_paths::arguments(shortest.as_ref()))
            .chain(agent_arguments)
            .collect(),
        checkpoint: Some(PathBuf::from(parameters.text("out")).join(CHECKPOINT)),
    })
}
