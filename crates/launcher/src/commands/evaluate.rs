//! `evac evaluate`: the greedy test of a trained model.

use std::process::ExitCode;

use clap::{ArgMatches, Command};

use super::{
    AGENT, SIMULATOR, agent_arguments, check_model, fewest_steps::FewestStepsFile, parameters_of,
    ros_arguments, simulator_arguments, supervise,
};
use crate::{
    command_line::{given, with_parameters},
    parameters::Parameters,
    programs,
    supervision::Plan,
};

pub fn command() -> anyhow::Result<Command> {
    let command = Command::new("evaluate")
        .about("Test a trained model over DDS: the best action always, no exploration")
        .arg(ros_arguments());
    let agent = parameters_of(&programs::find("agent_node")?, "evaluate")?;
    let simulator = Parameters::of(&programs::find("sim_node")?, None, &[])?;
    let command = with_parameters(command, &agent, AGENT);
    Ok(with_parameters(command, &simulator, SIMULATOR))
}

pub fn run(matches: &ArgMatches) -> anyhow::Result<ExitCode> {
    let (agent, simulator) = (programs::find("agent_node")?, programs::find("sim_node")?);
    let options = parameters_of(&agent, "evaluate")?;
    let given_options = given(matches, &options, None);
    if let Some(model) = matches.get_one::<String>("model") {
        check_model(model)?;
    }
    let mut agent_arguments = agent_arguments(matches, given_options);
    let parameters = Parameters::of(&agent, Some("evaluate"), &agent_arguments)?;
    check_model(parameters.text("model"))?;
    let own = given(matches, &Parameters::of(&simulator, None, &[])?, Some(&options));
    Parameters::of(&simulator, None, &simulator_arguments("", &own))?;

    let fewest = FewestStepsFile::compute(
        &simulator,
        &simulator_arguments("", &own),
        parameters.text("scenario"),
        parameters.count("seed"),
        parameters.count("episodes"),
    )?;
    let mut arguments = vec!["evaluate".to_owned()];
    arguments.extend(fewest.iter().flat_map(FewestStepsFile::arguments));
    arguments.append(&mut agent_arguments);
    supervise(&Plan {
        simulators: vec![simulator_arguments("", &own)],
        simulator,
        agent,
        agent_arguments: arguments,
        checkpoint: None,
    })
}
