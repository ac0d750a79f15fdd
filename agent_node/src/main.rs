//! `agent_node train | evaluate | drive | parameters | seeds`: see `--help`.

use std::{path::PathBuf, process::ExitCode};

use agent_node::ros::{NodeCommand, drive::drive, evaluate::evaluate, parameters_of, train::train};
use anyhow::Context;
use clap::{Parser, Subcommand};
use ros_runtime::{Arguments, failure};
use task::seeds::{Purpose, episode_seed};

/// Learns by deep Dyna-Q, from camera images alone, to drive a robot out of a room.
#[derive(Parser)]
#[command(version = ros_runtime::version!(), after_help = "Options are ROS parameters: --ros-args -p episodes:=100")]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
    /// End when the process with this id ends, which has started this one
    #[arg(long, global = true)]
    parent: Option<u32>,
}

#[derive(Subcommand)]
enum Command {
    /// Train over DDS, then test; everything is left in the directory of the parameter `out`
    Train {
        /// What `sim_node oracle` printed for the seeds of the test
        #[arg(long)]
        oracle: Option<PathBuf>,
    },
    /// Test the model in the directory of the parameter `model`, without exploration
    Evaluate {
        /// What `sim_node oracle` printed for the seeds of the test
        #[arg(long)]
        oracle: Option<PathBuf>,
    },
    /// Drive a robot with the model in the directory of the parameter `model`: hear only
    /// `camera/image`, say only `action`
    Drive,
    /// Print the parameters of a command with their values, as JSON, or what is wrong with them (no DDS)
    Parameters {
        /// Which command
        of: NodeCommand,
    },
    /// Print the seeds of a test's resets, one a line (no DDS)
    Seeds {
        /// The seed of the test
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// How many episodes it has
        #[arg(long, default_value_t = 1000)]
        episodes: u32,
    },
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("agent_node: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> anyhow::Result<()> {
    failure::end_on_panic();
    // How much a training takes is up to its parameters; something is left for the others.
    if let Some(memory) = failure::machine_memory() {
        failure::limit_memory(memory / 2).context("the memory cannot be limited")?;
    }
    let arguments = Arguments::from_environment()?;
    let command_line = CommandLine::parse_from(&arguments.program);
    if let Some(parent) = command_line.parent {
        failure::end_with_parent(parent).context("--parent")?;
    }
    match command_line.command {
        Command::Parameters { of } => {
            println!("{}", serde_json::to_string(&parameters_of(of, &arguments)?)?);
            Ok(())
        }
        Command::Train { oracle } => train(&arguments, oracle.as_deref()),
        Command::Evaluate { oracle } => evaluate(&arguments, oracle.as_deref()),
        Command::Drive => drive(&arguments),
        Command::Seeds { seed, episodes } => {
            for episode in 0..episodes {
                println!("{}", episode_seed(Purpose::Test, seed, episode));
            }
            Ok(())
        }
    }
}
