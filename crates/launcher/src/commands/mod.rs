//! What the program does.

mod drive;
mod evaluate;
mod experiment;
mod fewest_steps;
mod train;

use std::{ffi::OsString, io, path::Path, process::ExitCode};

use anyhow::bail;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use clap_complete::{Shell, generate};

use crate::{
    parameters::Parameters,
    supervision::{self, Plan},
};

/// The option of `train` and `evaluate` that is no parameter: how many simulators there are is one, of
/// the agent.
const SIMULATOR: &str = "Parameters of the simulator";
const AGENT: &str = "Parameters of the agent";

/// Does what a command line says.
pub fn run(arguments: impl Iterator<Item = OsString>) -> anyhow::Result<ExitCode> {
    // `ros2 launch` ends the arguments of every node with this.
    let mut arguments: Vec<OsString> = arguments.collect();
    if let Some(end) = arguments.iter_mut().find(|item| *item == "--ros-args" || *item == "--") {
        *end = "--".into();
    }
    let matches = command_line()?.get_matches_from(arguments);
    match matches.subcommand() {
        Some(("train", matches)) => train::run(matches),
        Some(("evaluate", matches)) => evaluate::run(matches),
        Some(("drive", matches)) => drive::run(matches),
        Some(("completions", matches)) => {
            let shell = *matches.get_one::<Shell>("shell").unwrap_or(&Shell::Bash);
            generate(shell, &mut command_line()?, "evac", &mut io::stdout());
            Ok(ExitCode::SUCCESS)
        }
        Some((name, matches)) => experiment::run(name, matches),
        None => bail!("a command is missing: see --help"),
    }
}

fn command_line() -> anyhow::Result<Command> {
    let completions = Command::new("completions")
        .about("Print the completions of a shell: source <(evac completions bash)")
        .arg(Arg::new("shell").required(true).value_parser(value_parser!(Shell)));
    Ok(Command::new("evac")
        .about("Starts the nodes of Evac, watches them, and ends them")
        .version(env!("CARGO_PKG_VERSION"))
        .subcommand_required(true)
        .subcommand(train::command()?)
        .subcommand(evaluate::command()?)
        .subcommand(drive::command()?)
        .subcommands(experiment::commands())
        .subcommand(completions))
}

/// What else a node is told: `-- --ros-args -p learning_rate:=0.001`.
fn ros_arguments() -> Arg {
    Arg::new("ros")
        .help("ROS arguments of the agent, after --")
        .value_name("ROS ARGUMENTS")
        .num_args(0..)
        .last(true)
        .action(ArgAction::Append)
}

/// The ROS arguments of the agent: the options, then what stands after `--`.
fn agent_arguments(matches: &ArgMatches, options: Vec<String>) -> Vec<String> {
    let mut arguments = vec!["--ros-args".to_owned()];
    // Whose keys it has, where there is security; whoever gives another one wins.
    arguments.extend(["--enclave", "/evac/agent_node"].map(str::to_owned));
    arguments.extend(options);
    arguments.extend(matches.get_many::<String>("ros").into_iter().flatten().cloned());
    arguments.push("--".to_owned());
    arguments
}

/// The arguments of a simulator in a namespace, which is empty for that of the agent.
fn simulator_arguments(namespace: &str, options: &[String]) -> Vec<String> {
    let mut arguments = ["--ros-args", "--enclave", "/evac/sim_node"].map(str::to_owned).to_vec();
    if !namespace.is_empty() {
        arguments.extend(["-r".to_owned(), format!("__ns:=/{namespace}")]);
    }
    arguments.extend_from_slice(options);
    arguments.push("--".to_owned());
    arguments
}

/// Fails unless there is a trained model where the parameter `model` says.
fn check_model(model: &str) -> anyhow::Result<()> {
    match model {
        "" => bail!("which model? give --model DIR, the directory of a training"),
        model if Path::new(model).join("config.yaml").is_file() => Ok(()),
        model => bail!("no trained model in {model}: there is no config.yaml"),
    }
}

/// What the agent's parameters are without any argument: its options.
fn parameters_of(agent: &Path, command: &str) -> anyhow::Result<Parameters> {
    Parameters::of(agent, Some(command), &[])
}

/// Runs the nodes of a plan on this thread.
fn supervise(plan: &Plan) -> anyhow::Result<ExitCode> {
    // One thread, which has started all children, and which they end with.
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(supervision::run(plan))
}
