//! `sim_node [oracle | parameters]`: see `--help`.

use std::{fs, path::PathBuf, process::ExitCode};

use anyhow::Context;
use clap::{Parser, Subcommand};
use ros_runtime::{Arguments, Node, failure, names::Naming, parameters::Parameters};
use sim_node::{
    ros::{self, SimulatorParameters},
    world::{World, fewest_steps},
};
use task::{FewestSteps, Scenario};

/// A room with a robot that has a 20x7 camera: serves reset and step, publishes what the robot sees.
#[derive(Parser)]
#[command(version = ros_runtime::version!(), after_help = "Options are ROS parameters: --ros-args -p scenario:=concave")]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    /// End when the process with this id ends, which has started this one
    #[arg(long, global = true)]
    parent: Option<u32>,
}

#[derive(Subcommand)]
enum Command {
    /// Print, as JSON, the fewest steps out of the room for each seed of a reset (no DDS)
    Oracle {
        /// The scenario
        #[arg(long)]
        scenario: Scenario,
        /// A file of seeds, one a line, as `agent_node seeds` prints them
        #[arg(long)]
        seeds: PathBuf,
    },
    /// Print the node's parameters with their values, as JSON, or what is wrong with them (no DDS)
    Parameters,
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("sim_node: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Many times what a room takes: more is taken only for packets that lie about their size.
const MOST_MEMORY: u64 = 1 << 30;

fn run() -> anyhow::Result<()> {
    failure::end_on_panic();
    failure::limit_memory(MOST_MEMORY).context("the memory cannot be limited")?;
    let arguments = Arguments::from_environment()?;
    let command_line = CommandLine::parse_from(&arguments.program);
    if let Some(parent) = command_line.parent {
        failure::end_with_parent(parent).context("--parent")?;
    }
    match command_line.command {
        None => ros::run(&arguments),
        Some(Command::Parameters) => {
            let parameters = Node::parameters_alone("sim_node", &arguments)?;
            SimulatorParameters::declare(&parameters)?;
            println!("{}", serde_json::to_string(&parameters.declarations())?);
            Ok(())
        }
        Some(Command::Oracle { scenario, seeds }) => {
            let text = fs::read_to_string(&seeds).with_context(|| seeds.display().to_string())?;
            let result = oracle(&arguments, scenario, &text)?;
            println!("{}", serde_json::to_string(&result)?);
            Ok(())
        }
    }
}

fn oracle(arguments: &Arguments, scenario: Scenario, seeds: &str) -> anyhow::Result<FewestSteps> {
    let naming = Naming::new("sim_node", &arguments.remaps)?;
    let room = ros::declare_room(&Parameters::new(&naming, arguments)?)?;
    let mut world = World::new(room.world, scenario, room.seed)?;
    let (mut all, mut steps) = (Vec::new(), Vec::new());
    for (line, seed) in seeds.lines().enumerate() {
        let seed = seed.trim().parse().with_context(|| {
            format!("line {}: '{seed}' is no seed: expected a number from 1", line + 1)
        })?;
        world.reset(Some(seed), Some(scenario))?;
        all.push(seed);
        steps.push(fewest_steps(&world));
    }
    Ok(FewestSteps::new(scenario.name(), all, steps))
}
