//! `agent_node train | evaluate | drive | reproduction | seeds`: see `--help`.

use std::{path::PathBuf, process::ExitCode};

use agent_node::ros::{drive::drive, evaluate::evaluate, train::train};
use anyhow::Context;
use clap::{Parser, Subcommand};
use report::Reproduction;
use ros_runtime::{Arguments, failure};
use task::seeds::{Purpose, episode_seed};

/// Learns by deep Dyna-Q, from camera images alone, to drive a robot out of a room.
#[derive(Parser)]
#[command(version = ros_runtime::version!(), after_help = "Options are ROS parameters: --ros-args -p episodes:=100")]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
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
    /// Sum up what launch_scripts/reproduce.sh has trained and tested (no DDS)
    Reproduction {
        /// The directory of the trainings
        runs: PathBuf,
        /// Where the figures go, as JSON
        #[arg(long)]
        json: PathBuf,
        /// The page that holds the tables, between comments
        #[arg(long)]
        results: PathBuf,
        /// The page that holds the short table
        #[arg(long)]
        readme: PathBuf,
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
    match CommandLine::parse_from(&arguments.program).command {
        Command::Train { oracle } => train(&arguments, oracle.as_deref()),
        Command::Evaluate { oracle } => evaluate(&arguments, oracle.as_deref()),
        Command::Drive => drive(&arguments),
        Command::Reproduction { runs, json, results, readme } => {
            let reproduction = Reproduction::read(&runs)?;
            reproduction.write_json(&json)?;
            reproduction.write_results(&results)?;
            reproduction.write_readme(&readme)
        }
        Command::Seeds { seed, episodes } => {
            for episode in 0..episodes {
                println!("{}", episode_seed(Purpose::Test, seed, episode));
            }
            Ok(())
        }
    }
}
