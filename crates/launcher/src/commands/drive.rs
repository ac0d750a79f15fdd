//! `evac drive`: a trained model drives, as on a robot.

use std::process::ExitCode;

use anyhow::bail;
use clap::{Arg, ArgAction, ArgMatches, Command};

use super::{
    AGENT, SIMULATOR, agent_arguments, check_model, parameters_of, ros_arguments,
    simulator_arguments, supervise,
};
use crate::{
    command_line::{given, with_parameters},
    parameters::Parameters,
    programs,
    supervision::Plan,
};

/// What a simulator in a robot's place does unless it is told otherwise.
const IN_REAL_TIME: [(&str, &str); 3] =
    [("frame_rate", "20.0"), ("motion_time", "0.1"), ("auto_reset", "true")];
/// By it the agent waits for the next image after one that it has answered.
const SETTLE_TIME: (&str, &str) = ("settle_time", "0.2");

pub fn command() -> anyhow::Result<Command> {
    let command = Command::new("drive")
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
        .arg(ros_arguments());
    let agent = parameters_of(&programs::find("agent_node")?, "drive")?;
    let simulator = Parameters::of(&programs::find("sim_node")?, None, &[])?;
    let command = with_parameters(command, &agent, AGENT);
    Ok(with_parameters(command, &simulator, SIMULATOR))
}

pub fn run(matches: &ArgMatches) -> anyhow::Result<ExitCode> {
    let (agent, simulator) = (programs::find("agent_node")?, programs::find("sim_node")?);
    let options = parameters_of(&agent, "drive")?;
    if let Some(model) = matches.get_one::<String>("model") {
        check_model(model)?;
    }
    let mut given_options = defaults(matches, &[SETTLE_TIME]);
    given_options.extend(given(matches, &options, None));
    let mut agent_arguments = agent_arguments(matches, given_options);
    let parameters = Parameters::of(&agent, Some("drive"), &agent_arguments)?;
    let model = parameters.text("model");
    check_model(model)?;
    let own = given(matches, &Parameters::of(&simulator, None, &[])?, Some(&options));
    let simulators = match matches.get_flag("robot") {
        true if own.is_empty() => Vec::new(),
        true => bail!("with --robot there is no simulator that could be told {}", own[1]),
        false => {
            let mut arguments = defaults(matches, &IN_REAL_TIME);
            if matches.get_one::<String>("scenario").is_none() {
                arguments.extend(scenario_of(&agent, model)?);
            }
            arguments.extend(own);
            vec![simulator_arguments("", &arguments)]
        }
    };
    for arguments in &simulators {
        Parameters::of(&simulator, None, arguments)?;
    }
    let mut arguments = vec!["drive".to_owned()];
    arguments.append(&mut agent_arguments);
    supervise(&Plan { simulators, simulator, agent, agent_arguments: arguments, checkpoint: None })
}

/// `-p NAME:=VALUE` of what is not given as an option.
fn defaults(matches: &ArgMatches, values: &[(&str, &str)]) -> Vec<String> {
    let missing = values.iter().filter(|(name, _)| matches.get_one::<String>(name).is_none());
    missing.flat_map(|(name, value)| ["-p".to_owned(), format!("{name}:={value}")]).collect()
}

/// The scenario that a model was trained in, for a simulator.
fn scenario_of(agent: &std::path::Path, model: &str) -> anyhow::Result<Vec<String>> {
    let arguments = ["--ros-args", "-p", &format!("model:='{}'", model.replace('\'', "''"))];
    let arguments = arguments.map(str::to_owned);
    let parameters = Parameters::of(agent, Some("evaluate"), &arguments)?;
    match parameters.text("scenario") {
        "mixed" => bail!("the model was trained in all rooms: choose one with --scenario"),
        scenario => Ok(vec!["-p".to_owned(), format!("scenario:={scenario}")]),
    }
}
