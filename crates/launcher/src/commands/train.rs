//! `evac train`: a training, and the test of what it has learned.

use std::{path::PathBuf, process::ExitCode};

use clap::{ArgMatches, Command};

use super::{
    AGENT, SIMULATOR, agent_arguments, fewest_steps::FewestStepsFile, parameters_of, ros_arguments,
    simulator_arguments, supervise,
};
use crate::{
    command_line::{given, with_parameters},
    parameters::Parameters,
    programs,
    supervision::Plan,
};

/// The file that a training goes on from.
const CHECKPOINT: &str = "checkpoint.safetensors";

pub fn command() -> anyhow::Result<Command> {
    let command = Command::new("train")
        .about("Train the agent over DDS, then test it: two processes, simulator and agent")
        .after_help(
            "Ctrl-C saves the training and ends both nodes; the same command with --resume goes on.",
        )
        .arg(ros_arguments());
    let agent = parameters_of(&programs::find("agent_node")?, "train")?;
    let simulator = Parameters::of(&programs::find("sim_node")?, None, &[])?;
    let command = with_parameters(command, &agent, AGENT);
    Ok(with_parameters(command, &simulator, SIMULATOR))
}

pub fn run(matches: &ArgMatches) -> anyhow::Result<ExitCode> {
    let (agent, simulator) = (programs::find("agent_node")?, programs::find("sim_node")?);
    let options = parameters_of(&agent, "train")?;
    let mut agent_arguments = agent_arguments(matches, given(matches, &options, None));
    // What the node says to them before anything is started: they are wrong, or what they come to.
    let parameters = Parameters::of(&agent, Some("train"), &agent_arguments)?;
    let own = given(matches, &Parameters::of(&simulator, None, &[])?, Some(&options));
    Parameters::of(&simulator, None, &simulator_arguments("", &own))?;

    let (episodes, seed) =
        (parameters.count("evaluation_episodes"), parameters.count("evaluation_seed"));
    let fewest = FewestStepsFile::compute(
        &simulator,
        &simulator_arguments("", &own),
        parameters.text("scenario"),
        seed,
        episodes,
    )?;
    let mut arguments = vec!["train".to_owned()];
    arguments.extend(fewest.iter().flat_map(FewestStepsFile::arguments));
    arguments.append(&mut agent_arguments);
    let simulators = match parameters.count("simulators") {
        0 | 1 => vec![simulator_arguments("", &own)],
        count => (0..count).map(|n| simulator_arguments(&format!("sim{n}"), &own)).collect(),
    };
    supervise(&Plan {
        simulator,
        simulators,
        agent,
        agent_arguments: arguments,
        checkpoint: Some(PathBuf::from(parameters.text("out")).join(CHECKPOINT)),
    })
}
