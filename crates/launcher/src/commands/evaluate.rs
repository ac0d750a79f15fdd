//! `evac evaluate`: evaluates a trained model.

use std::process::ExitCode;

use clap::{ArgMatches, Command};

use super::{model, nodes::Nodes, shortest_paths};
use crate::supervision::{Plan, supervise};

pub fn command() -> Command {
    Command::new("evaluate")
        .about("Evaluate a trained model over DDS with the greedy policy (no exploration)")
}

pub fn run(matches: &ArgMatches, nodes: &Nodes) -> anyhow::Result<ExitCode> {
    // Checked first, because the agent reads the model to determine its parameters.
    if let Some(model) = matches.get_one::<String>("model") {
        model::check(model)?;
    }
    let (agent_arguments, parameters) = nodes.agent_arguments(matches, Vec::new())?;
    model::check(parameters.text("model"))?;
    let simulator = nodes.simulator_arguments("", &nodes.simulator_options(matches))?;
    let evaluation = (parameters.count("seed"), parameters.count("episodes"));
    let scenario = parameters.text("scenario");
    let shortest = shortest_paths::compute(&nodes.simulator, &simulator, scenario, evaluation)?;
    let command = ["evaluate".to_owned()].into_iter();
    supervise(&Plan {
        simulator: nodes.simulator.clone(),
        simulators: vec![simulator],
        agent: nodes.agent.clone(),
        agent_arguments: command
            .chain(shortest_paths::arguments(shortest.as_ref()))
            .chain(agent_arguments)
            .collect(),
        checkpoint: None,
    })
}
