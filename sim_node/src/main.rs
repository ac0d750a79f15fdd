//! The program `sim_node [oracle | parameters]`; see `--help`.

use std::{
    fs,
    io::{self, Write},
    path::PathBuf,
    process::ExitCode,
};

use anyhow::Context;
use clap::{Parser, Subcommand};
use ros_runtime::{Arguments, Node, failure, names::Naming, parameters::Parameters};
use sim_node::{
    ros::{self, SimulatorParameters},
    world::{World, shortest_path_length},
};
use task::{Scenario, ShortestPaths};

/// Simulates a room with an exit, obstacles and a robot with a 20x7 camera; provides the services
/// reset and step, and publishes camera images.
#[derive(Parser)]
#[command(
    version = ros_runtime::version!(),
    after_help = "Options are ROS parameters, for example: --ros-args -p scenario:=concave"
)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    /// Exit when the parent process with this process ID exits
    #[arg(long, global = true)]
    parent: Option<u32>,
}

#[derive(Subcommand)]
enum Command {
    /// Print the length of the full-knowledge shortest path of each episode as JSON; does not use
    /// DDS
    Oracle {
        /// Scenario of the episodes
        #[arg(long)]
        scenario: Scenario,
        /// File with the episode seeds, one per line, as printed by `agent_node seeds`
        #[arg(long)]
        seeds: PathBuf,
    },
    /// Print the parameters of the node and their values as JSON, or an error for the first invalid
    /// value; does not use DDS
    Parameters,
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of the output has seen enough: `agent_node seeds | head -n 1`.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("sim_node: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Memory limit in bytes: 1 GiB, far more than the simulator uses. Only packets that declare a
/// false size could make the simulator reach it.
const MEMORY_LIMIT: u64 = 1 << 30;

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let error = error.downcast_ref::<io::Error>();
    error.is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

fn run() -> anyhow::Result<()> {
    failure::exit_on_panic();
    failure::limit_memory(MEMORY_LIMIT).context("cannot limit the memory of the process")?;
    let arguments = Arguments::from_environment()?;
    let command_line = CommandLine::parse_from(&arguments.program);
    if let Some(parent) = command_line.parent {
        failure::exit_with_parent(parent).with_context(|| format!("--parent {parent}"))?;
    }
    match command_line.command {
        None => ros::run(&arguments),
        Some(Command::Parameters) => {
            let parameters = Node::parameters_only("sim_node", &arguments)?;
            SimulatorParameters::declare(&parameters)?;
            writeln!(io::stdout(), "{}", serde_json::to_string(&parameters.declarations())?)?;
            Ok(())
        }
        Some(Command::Oracle { scenario, seeds }) => {
            let text = fs::read_to_string(&seeds).with_context(|| seeds.display().to_string())?;
            let result = oracle(&arguments, scenario, &text)?;
            writeln!(io::stdout(), "{}", serde_json::to_string(&result)?)?;
            Ok(())
        }
    }
}

/// Returns the length of the full-knowledge shortest path of each episode. `seeds` contains the
/// episode seeds, one per line.
fn oracle(arguments: &Arguments, scenario: Scenario, seeds: &str) -> anyhow::Result<ShortestPaths> {
    let naming = Naming::new("sim_node", &arguments.remaps)?;
    let room = ros::declare_room(&Parameters::new(&naming, arguments)?)?;
    let mut world = World::new(room.world, scenario, room.seed)?;
    let (mut valid_seeds, mut lengths) = (Vec::new(), Vec::new());
    for (line, seed) in seeds.lines().enumerate() {
        let seed = seed.trim().parse().with_context(|| {
            format!("line {}: invalid seed '{seed}' (expected: an integer of at least 1)", line + 1)
        })?;
        world.reset(Some(seed), Some(scenario))?;
        valid_seeds.push(seed);
        lengths.push(shortest_path_length(&world));
    }
    Ok(ShortestPaths::new(scenario.name(), valid_seeds, lengths))
}
