//! The program `agent_node train | evaluate | drive | parameters | seeds`; see `--help`.

use std::{
    io::{self, Write},
    path::PathBuf,
    process::ExitCode,
};

use agent_node::ros::{NodeCommand, drive::drive, evaluate::evaluate, parameters_of, train::train};
use anyhow::Context;
use clap::{Parser, Subcommand};
use ros_runtime::{Arguments, failure};
use task::seeds::{Purpose, episode_seed};

/// Trains, evaluates and deploys a deep Dyna-Q agent that drives a robot out of a room using camera
/// images only.
#[derive(Parser)]
#[command(
    version = ros_runtime::version!(),
    after_help = "Options are ROS parameters, for example: --ros-args -p episodes:=100"
)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
    /// Exit when the parent process with this process ID exits
    #[arg(long, global = true)]
    parent: Option<u32>,
}

#[derive(Subcommand)]
enum Command {
    /// Train over DDS, then evaluate the policy; write all results to the directory given by the
    /// parameter `out`
    Train {
        /// File with the output of `sim_node oracle` for the evaluation episodes: the lengths of
        /// the full-knowledge shortest paths
        #[arg(long)]
        oracle: Option<PathBuf>,
    },
    /// Evaluate the model in the directory given by the parameter `model`, without exploration
    Evaluate {
        /// File with the output of `sim_node oracle` for the evaluation episodes: the lengths of
        /// the full-knowledge shortest paths
        #[arg(long)]
        oracle: Option<PathBuf>,
    },
    /// Drive a robot with the model in the directory given by the parameter `model`: subscribe to
    /// `camera/image` and publish commands on `action`
    Drive,
    /// Print the parameters of a command and their values as JSON, or an error for the first
    /// invalid value; does not use DDS
    Parameters {
        /// Command whose parameters to print
        command: NodeCommand,
    },
    /// Print the episode seeds of an evaluation, one per line; does not use DDS
    Seeds {
        /// Evaluation seed
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Number of evaluation episodes
        #[arg(long, default_value_t = 1000)]
        episodes: u32,
    },
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of the output has seen enough: `agent_node seeds | head -n 1`.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("agent_node: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let error = error.downcast_ref::<io::Error>();
    error.is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

fn run() -> anyhow::Result<()> {
    failure::exit_on_panic();
    // The replay memory can grow to memory_capacity transitions. The limit leaves memory for other
    // processes.
    if let Some(memory) = failure::machine_memory() {
        failure::limit_memory(memory / 2).context("cannot limit the memory of the process")?;
    }
    let arguments = Arguments::from_environment()?;
    let command_line = CommandLine::parse_from(&arguments.program);
    if let Some(parent) = command_line.parent {
        failure::exit_with_parent(parent).with_context(|| format!("--parent {parent}"))?;
    }
    match command_line.command {
        Command::Parameters { command } => {
            writeln!(
                io::stdout(),
                "{}",
                serde_json::to_string(&parameters_of(command, &arguments)?)?
            )?;
            Ok(())
        }
        Command::Train { oracle } => train(&arguments, oracle.as_deref()),
        Command::Evaluate { oracle } => evaluate(&arguments, oracle.as_deref()),
        Command::Drive => drive(&arguments),
        Command::Seeds { seed, episodes } => {
            for episode in 0..episodes {
                writeln!(io::stdout(), "{}", episode_seed(Purpose::Evaluation, seed, episode))?;
            }
            Ok(())
        }
    }
}
