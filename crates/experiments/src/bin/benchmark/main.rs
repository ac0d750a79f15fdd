//! The benchmarks of `launch_scripts/bench.sh`: everything that speed is promised for, beside its
//! rulers, in one run.

mod learner;
mod peers;
mod report;
mod room;
mod round_trip;
mod scale;
mod start_up;
mod training;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use self::{peers::PeerFigures, report::Report};

/// Measures learner, simulator and network beside their rulers, as a table and as JSON.
#[derive(Parser)]
struct CommandLine {
    #[command(subcommand)]
    other_side: Option<OtherSide>,
    /// Where the figures go, as JSON
    #[arg(long, default_value = "bench.json")]
    out: PathBuf,
    /// Measures other people's software in the same run: PyTorch, Stable-Baselines3 and CycloneDDS from
    /// PyPI, some 5 GB that go into .venv-bench, and CycloneDDS's ddsperf where it is on the PATH
    /// (Debian: cyclonedds-tools)
    #[arg(long)]
    peers: bool,
    /// Also trains in several rooms at once that take their time
    #[arg(long)]
    scale: bool,
}

/// The other process of a round trip; started by the benchmark itself.
#[derive(Subcommand)]
enum OtherSide {
    /// Answers every datagram
    #[command(hide = true)]
    UdpEcho,
    /// Answers every request of the service `plain_step`, by ros2-client alone
    #[command(hide = true)]
    PlainServer,
}

fn main() -> anyhow::Result<()> {
    let command_line = CommandLine::parse();
    match command_line.other_side {
        Some(OtherSide::UdpEcho) => return round_trip::udp_echo(),
        Some(OtherSide::PlainServer) => return round_trip::plain_server(),
        None => {}
    }
    // candle's matrix product, the ruler of the update, takes as many threads as this says.
    let threads = std::env::var("RAYON_NUM_THREADS").unwrap_or_default();
    anyhow::ensure!(
        threads == "1",
        "RAYON_NUM_THREADS is '{threads}' (expected: 1, as the baseline is single-threaded): use 'evac bench'"
    );
    let report = Report {
        room: part("the simulator", room::measure)?,
        learner: part("the learner", learner::measure)?,
        round_trip: part("round trips over the network", round_trip::measure)?,
        start_up: part("how soon the nodes hear each other", start_up::measure)?,
        training: part("whole trainings, in one process and over DDS", training::measure)?,
        scale: match command_line.scale {
            true => part("trainings in several rooms at once", scale::measure)?,
            false => Vec::new(),
        },
        peers: match command_line.peers {
            true => part("the peers", peers::measure)?,
            false => PeerFigures::default(),
        },
    };
    print!("{}", report.table());
    std::fs::write(&command_line.out, report.json()?)?;
    println!("\nThe figures are in {}.", command_line.out.display());
    Ok(())
}

/// Measures a part, and says so.
fn part<T>(name: &str, measure: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    eprintln!("measuring {name} ...");
    measure()
}

/// The value below which a share of the values lies.
fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}

fn median(values: &mut [f64]) -> f64 {
    percentile(values, 0.5)
}
