//! `evac evaluate`: the evaluation of a trained model.

use std::process::ExitCode;

use clap::{ArgMatches, Command};

use super::{check_model, fewest_steps, nodes::Nodes, supervise};
use crate::supervision::Plan;

pub fn command() -> Command {
    Command::new("evaluate")
        .about("Test a trained model over DDS: the best action always, no exploration")
}

pub fn run(matches: &ArgMatches, nodes: &Nodes) -> anyhow::Result<ExitCode> {
    // Before the node reads the model for its parameters.
    if let Some(model) = matches.get_one::<String>("model") {
        check_model(model)?;
    }
    let (agent_arguments, parameters) = nodes.agent_arguments(matches, Vec::new())?;
    check_model(parameters.text("model"))?;
    let simulator = nodes.simulator_arguments("", &nodes.simulator_options(matches))?;
    let evaluation = (parameters.count("seed"), parameters.count("episodes"));
    let scenario = parameters.text("scenario");
    let fewest = fewest_steps::compute(&nodes.simulator, &simulator, scenario, evaluation)?;
    let command = ["evaluate".to_owned()].into_iter();
    supervise(&Plan {
        simulator: nodes.simulator.clone(),
        simulators: vec![simulator],
        agent: nodes.agent.clone(),
        agent_arguments: command
            .chain(fewest_steps::arguments(fewest.as_ref()))
            .chain(agent_arguments)
            .collect(),
        checkpoint: None,
    })
}
