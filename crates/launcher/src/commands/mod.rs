//! The commands of `evac`.

mod drive;
mod evaluate;
mod experiment;
mod model;
mod nodes;
mod shortest_paths;
mod train;

use std::{
    ffi::OsString,
    io::{self, Write},
    process::ExitCode,
};

use anyhow::bail;
use clap::{Arg, ArgMatches, Command, value_parser};
use clap_complete::{Shell, generate};

use self::nodes::Nodes;

/// The commands that start nodes. Their options include the parameters of the nodes.
const NODE_COMMANDS: [&str; 3] = ["train", "evaluate", "drive"];

/// Parses the command line and runs the command. The first of `arguments` is the program name.
///
/// # Errors
///
/// Returns an error if the arguments are invalid for the nodes, or if the command fails. If clap
/// rejects the arguments, prints its error and exits the process with status 2.
pub fn run(arguments: impl Iterator<Item = OsString>) -> anyhow::Result<ExitCode> {
    // `ros2 launch` appends --ros-args to the arguments of every node. Everything after
    // --ros-args goes to the agent, as with `--`.
    let mut arguments: Vec<OsString> = arguments.collect();
    if let Some(separator) =
        arguments.iter_mut().find(|item| *item == "--ros-args" || *item == "--")
    {
        *separator = "--".into();
    }
    // Queries take time, so the nodes are queried only if the given command starts them.
    let is_given = |name: &&str| arguments.get(1).is_some_and(|command| command == *name);
    let nodes = NODE_COMMANDS.into_iter().find(is_given).map(Nodes::query).transpose()?;
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
        (None, _) => bail!("missing command (evac --help lists the commands)"),
    }
}

/// Returns the definition of the command line. `options` adds the parameters of the nodes to a
/// command as options.
fn command_line(options: impl Fn(Command) -> Command) -> Command {
    let completions = Command::new("completions")
        .about("Print shell completions, for example for bash: source <(evac completions bash)")
        .arg(Arg::new("shell").required(true).value_parser(value_parser!(Shell)));
    Command::new("evac")
        .about("Starts, supervises and stops the nodes of Evac")
        .version(env!("CARGO_PKG_VERSION"))
        .subcommand_required(true)
        .subcommands([train::command(), evaluate::command(), drive::command()].map(options))
        .subcommands(experiment::commands())
        .subcommand(completions)
}

fn print_completions(matches: &ArgMatches) -> anyhow::Result<ExitCode> {
    let shell = *matches.get_one::<Shell>("shell").unwrap_or(&Shell::Bash);
    let nodes = NODE_COMMANDS.map(Nodes::query).into_iter().collect::<anyhow::Result<Vec<_>>>()?;
    let mut command = command_line(|command| {
        match nodes.iter().find(|nodes| nodes.command() == command.get_name()) {
            Some(nodes) => nodes.add_options(command),
            None => command,
        }
    });
    // `generate` panics if it cannot write, for example because `head` has closed the pipe.
    let mut text = Vec::new();
    generate(shell, &mut command, "evac", &mut text);
    match io::stdout().write_all(&text) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(ExitCode::SUCCESS),
    }
}
