//! The benchmarks that `launch_scripts/bench.sh` runs. One run measures everything that has a
//! performance target, together with the baselines for comparison.

mod learner;
mod peers;
mod quantile;
mod report;
mod room;
mod round_trip;
mod scale;
mod start_up;
mod training;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use self::{peers::PeerFigures, report::Report};

/// Measures the learner, the simulator and the network against their baselines. Prints a table and
/// writes JSON.
#[derive(Parser)]
struct CommandLine {
    #[command(subcommand)]
    remote_end: Option<RemoteEnd>,
    /// Output file (JSON)
    #[arg(long, default_value = "bench.json")]
    out: PathBuf,
    /// Also measure third-party software: PyTorch, Stable-Baselines3 and CycloneDDS from PyPI
    /// (about 5 GB, installed in .venv-bench), and CycloneDDS's ddsperf if it is on the PATH
    /// (Debian: cyclonedds-tools)
    #[arg(long)]
    peers: bool,
    /// Also measure training with 1, 2, 4 and 8 simulators whose moves take 10 ms
    #[arg(long)]
    scale: bool,
}

/// The remote end of a round trip, which the benchmark starts as a second process.
#[derive(Subcommand)]
enum RemoteEnd {
    /// Reply to every datagram
    #[command(hide = true)]
    UdpEcho,
    /// Reply to every request to the service `plain_step`, using only ros2-client
    #[command(hide = true)]
    PlainServer,
}

fn main() -> anyhow::Result<()> {
    let command_line = CommandLine::parse();
    match command_line.remote_end {
        Some(RemoteEnd::UdpEcho) => return round_trip::udp_echo(),
        Some(RemoteEnd::PlainServer) => return round_trip::plain_server(),
        None => {}
    }
    // This variable sets the number of threads for candle's matrix product, the baseline for the
    // update.
    let threads = std::env::var("RAYON_NUM_THREADS").unwrap_or_default();
    anyhow::ensure!(
        threads == "1",
        "RAYON_NUM_THREADS is '{threads}' (expected: 1, because the baseline is \
         single-threaded): run 'evac bench' instead"
    );
    let report = Report {
        room: part("simulator", room::measure)?,
        learner: part("learner", learner::measure)?,
        round_trip: part("network round trips", round_trip::measure)?,
        start_up: part("start-up and discovery", start_up::measure)?,
        training: part("training in one process and over DDS", training::measure)?,
        scale: match command_line.scale {
            true => part("training with several simulators", scale::measure)?,
            false => Vec::new(),
        },
        peers: match command_line.peers {
            true => part("third-party software", peers::measure)?,
            false => PeerFigures::default(),
        },
    };
    print!("{}", report.table());
    std::fs::write(&command_line.out, report.json()?)?;
    println!("\nWrote {}.", command_line.out.display());
    Ok(())
}

/// Logs the name of a measurement and runs it.
fn part<T>(name: &str, measure: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    eprintln!("measuring {name} ...");
    measure()
}
