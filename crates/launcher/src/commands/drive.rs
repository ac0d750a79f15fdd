//! `evac drive`: a trained model drives, as on a robot.

use std::{path::Path, process::ExitCode};

use anyhow::bail;
use clap::{Arg, ArgAction, ArgMatches, Command};

use super::{check_model, nodes::Nodes, supervise};
use crate::{parameters::Parameters, supervision::Plan};

/// What the simulator does in a robot's place unless it is told otherwise.
const IN_REAL_TIME: [(&str, &str); 3] =
    [("frame_rate", "20.0"), ("motion_time", "0.1"), ("auto_reset", "true")];
/// How long the agent waits for the next image after one that it has answered, unless told otherwise.
const SETTLE_TIME: (&str, &str) = ("settle_time", "0.2");

pub fn command() -> Command {
    Command::new("drive")
        .about(
            "Drive with a trained model as on a robot: the agent hears only camera/image and says only \
             action. A simulator takes the robot's place, unless there is one",
        )
        .after_help(
            "It drives until Ctrl-C; an episode that is over is followed by the next. With --frame-rate 20, \
             --motion-time 0.1, --auto-reset and --settle-time 0.2, unless they are given.",
        )
        .arg(
            Arg::new("robot")
                .long("robot")
                .action(ArgAction::SetTrue)
                .help("There is a robot: start no simulator"),
        )
}

pub fn run(matches: &ArgMatches, nodes: &Nodes) -> anyhow::Result<ExitCode> {
    // Before the node reads the model for its parameters.
    if let Some(model) = matches.get_one::<String>("model") {
        check_model(model)?;
    }
    let (agent_arguments, parameters) =
        nodes.agent_arguments(matches, defaults(matches, &[SETTLE_TIME]))?;
    let model = parameters.text("model");
    check_model(model)?;
    let given = nodes.simulator_options(matches);
    let simulators = match matches.get_flag("robot") {
        true if given.is_empty() => Vec::new(),
        true => bail!("with --robot there is no simulator that could be told {}", given[1]),
        false => {
            let mut options = defaults(matches, &IN_REAL_TIME);
            if matches.get_one::<String>("scenario").is_none() {
                options.extend(scenario_of(&nodes.agent, model)?);
            }
            options.extend(given);
            vec![nodes.simulator_arguments("", &options)?]
        }
    };
    supervise(&Plan {
        simulator: nodes.simulator.clone(),
        simulators,
        agent: nodes.agent.clone(),
        agent_arguments: ["drive".to_owned()].into_iter().chain(agent_arguments).collect(),
        checkpoint: None,
    })
}

/// `-p NAME:=VALUE` of what is not given as an option.
fn defaults(matches: &ArgMatches, values: &[(&str, &str)]) -> Vec<String> {
    let missing = values.iter().filter(|(name, _)| matches.get_one::<String>(name).is_none());
    missing.flat_map(|(name, value)| ["-p".to_owned(), format!("{name}:={value}")]).collect()
}

/// The scenario that a model was trained in, for a simulator.
fn scenario_of(agent: &Path, model: &str) -> anyhow::Result<Vec<String>> {
    let arguments = ["--ros-args", "-p", &format!("model:='{}'", model.replace('\'', "''"))];
    let arguments = arguments.map(str::to_owned);
    let parameters = Parameters::of(agent, Some("evaluate"), &arguments)?;
    match parameters.text("scenario") {
        "mixed" => bail!("the model was trained in all rooms: choose one with --scenario"),
        scenario => Ok(vec!["-p".to_owned(), format!("scenario:={scenario}")]),
    }
}
