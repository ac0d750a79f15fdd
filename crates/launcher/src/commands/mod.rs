//! What the program does.

mod drive;
mod evaluate;
mod experiment;
mod fewest_steps;
mod nodes;
mod train;

use std::{ffi::OsString, io, path::Path, process::ExitCode};

use anyhow::bail;
use clap::{Arg, ArgMatches, Command, value_parser};
use clap_complete::{Shell, generate};

use self::nodes::Nodes;
use crate::supervision::{self, Plan};

/// The commands that start nodes, and whose options are the parameters of these.
const NODE_COMMANDS: [&str; 3] = ["train", "evaluate", "drive"];

/// Does what a command line says.
pub fn run(arguments: impl Iterator<Item = OsString>) -> anyhow::Result<ExitCode> {
    // `ros2 launch` ends the arguments of every node with this.
    let mut arguments: Vec<OsString> = arguments.collect();
    if let Some(end) = arguments.iter_mut().find(|item| *item == "--ros-args" || *item == "--") {
        *end = "--".into();
    }
    // Only the nodes of the command are asked for their parameters.
    let is_chosen = |name: &&str| arguments.get(1).is_some_and(|command| command == *name);
    let nodes = NODE_COMMANDS.into_iter().find(is_chosen).map(Nodes::of).transpose()?;
    let options = |command: Command| match &nodes {
        Some(nodes) if command.get_name() == nodes.command() => nodes.add_options(command),
        _ => command,
    };
    let matches = command_line(options).get_matches_from(&arguments);
    match (matches.subcommand(), &nodes) {
        (Some(("train", matches)), Some(nodes)) => train::run(matches, nodes),
        (Some(("evaluate", matches)), Some(nodes)) => evaluate::run(matches, nodes),
        (Some(("drive", matches)), Some(nodes)) => drive::run(matches, nodes),
        (Some(("completions", matches)), _) => print_completions(matches),
        (Some((name, matches)), _) => experiment::run(name, matches),
        (None, _) => bail!("a command is missing: see --help"),
    }
}

/// All commands; `options` adds those options that are parameters of nodes.
fn command_line(options: impl Fn(Command) -> Command) -> Command {
    let completions = Command::new("completions")
        .about("Print the completions of a shell: source <(evac completions bash)")
        .arg(Arg::new("shell").required(true).value_parser(value_parser!(Shell)));
    Command::new("evac")
        .about("Starts the nodes of Evac, watches them, and ends them")
        .version(env!("CARGO_PKG_VERSION"))
        .subcommand_required(true)
        .subcommands([train::command(), evaluate::command(), drive::command()].map(options))
        .subcommands(experiment::commands())
        .subcommand(completions)
}

fn print_completions(matches: &ArgMatches) -> anyhow::Result<ExitCode> {
    let shell = *matches.get_one::<Shell>("shell").unwrap_or(&Shell::Bash);
    let nodes = NODE_COMMANDS.map(Nodes::of).into_iter().collect::<anyhow::Result<Vec<_>>>()?;
    let mut command = command_line(|command| {
        match nodes.iter().find(|nodes| nodes.command() == command.get_name()) {
            Some(nodes) => nodes.add_options(command),
            None => command,
        }
    });
    generate(shell, &mut command, "evac", &mut io::stdout());
    Ok(ExitCode::SUCCESS)
}

/// Fails unless there is a trained model where the parameter `model` says.
fn check_model(model: &str) -> anyhow::Result<()> {
    match model {
        "" => bail!("which model? give --model DIR, the directory of a training"),
        model if Path::new(model).join("config.yaml").is_file() => Ok(()),
        model => bail!("no trained model in {model}: there is no config.yaml"),
    }
}

/// Runs the nodes of a plan on this thread.
fn supervise(plan: &Plan) -> anyhow::Result<ExitCode> {
    // One thread, which has started all children, and which they end with.
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(supervision::run(plan))
}
