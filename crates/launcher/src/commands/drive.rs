//! `evac drive`: deploys a trained model in a simulator or on a robot.

use std::{path::Path, process::ExitCode};

use anyhow::bail;
use clap::{Arg, ArgAction, ArgMatches, Command};

use super::{model, nodes::Nodes};
use crate::{
    parameters::Parameters,
    supervision::{Plan, supervise},
};

/// Defaults of the simulator, which make it behave like a robot in real time.
const SIMULATOR_DEFAULTS: [(&str, &str); 3] =
    [("frame_rate", "20.0"), ("motion_time", "0.1"), ("auto_reset", "true")];
/// Defaults of the agent.
const AGENT_DEFAULTS: [(&str, &str); 1] = [("settle_time", "0.2")];

pub fn command() -> Command {
    Command::new("drive")
        .about(
            "Drive a robot with a trained model. The agent subscribes only to camera/image and \
             publishes its commands on action. Starts a simulator in place of the robot unless \
             --robot is given",
        )
        .after_help(
            "Runs until Ctrl-C. The simulator starts a new episode when one ends. These \
             defaults differ from those listed above: --settle-time 0.2 and, for the simulator, \
             --frame-rate 20 --motion-time 0.1 --auto-reset true.",
        )
        .arg(
            Arg::new("robot")
                .long("robot")
                .action(ArgAction::SetTrue)
                .help("Drive a robot; do not start a simulator"),
        )
}

pub fn run(matches: &ArgMatches, nodes: &Nodes) -> anyhow::Result<ExitCode> {
    // Checked first, because the agent reads the model to determine its parameters.
    if let Some(model) = matches.get_one::<String>("model") {
        model::check(model)?;
    }
    let (agent_arguments, parameters) =
        nodes.agent_arguments(matches, defaults(matches, &AGENT_DEFAULTS))?;
    let model = parameters.text("model");
    model::check(model)?;
    let given_options = nodes.simulator_options(matches);
    let simulators = match matches.get_flag("robot") {
        true if given_options.is_empty() => Vec::new(),
        true => bail!(
            "--robot conflicts with the simulator parameter {} because no simulator is started \
             (remove one of the two)",
            given_options[1]
        ),
        false => {
            let mut options = defaults(matches, &SIMULATOR_DEFAULTS);
            if matches.get_one::<String>("scenario").is_none() {
                options.extend(scenario_of(&nodes.agent, model)?);
            }
            options.extend(given_options);
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

/// Returns the ROS arguments (`-p NAME:=VALUE`) for those of `values` whose parameters are not
/// given as options.
fn defaults(matches: &ArgMatches, values: &[(&str, &str)]) -> Vec<String> {
    let missing = values.iter().filter(|(name, _)| matches.get_one::<String>(name).is_none());
    missing.flat_map(|(name, value)| ["-p".to_owned(), format!("{name}:={value}")]).collect()
}

/// Returns the ROS arguments that set the simulator to the scenario in which a model was trained.
fn scenario_of(agent: &Path, model: &str) -> anyhow::Result<Vec<String>> {
    let arguments = ["--ros-args", "-p", &format!("model:='{}'", model.replace('\'', "''"))];
    let arguments = arguments.map(str::to_owned);
    let parameters = Parameters::query(agent, Some("evaluate"), &arguments)?;
    match parameters.text("scenario") {
        "mixed" => {
            eprintln!(
                "evac drive: the model was trained in all scenarios; driving in three_moving \
                 (--scenario selects another)"
            );
            Ok(vec!["-p".to_owned(), "scenario:=three_moving".to_owned()])
        }
        scenario => Ok(vec!["-p".to_owned(), format!("scenario:={scenario}")]),
    }
}
