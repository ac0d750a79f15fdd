//! The benchmarks of `launch_scripts/bench.sh`: everything that speed is promised for, beside its
//! rulers, in one run.

mod learner;
mod peers;
mod report;
mod room;
mod round_trip;
mod training;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use self::report::Report;

/// Measures learner, simulator and network beside their rulers, as a table and as JSON.
#[derive(Parser)]
struct CommandLine {
    #[command(subcommand)]
    other_side: Option<OtherSide>,
    /// Where the figures go, as JSON
    #[arg(long, default_value = "bench.json")]
    out: PathBuf,
    /// A Python with the packages of tests/peers/benchmark/requirements.txt, to measure the peers
    #[arg(long)]
    peers: Option<PathBuf>,
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
    if std::env::var_os("RTT").is_some() {
        let r = round_trip::measure()?;
        for p in [&r.udp, &r.plain, &r.step] {
            println!("{:.0} {:.0} {:.0}", p.p50, p.p99, p.p999);
        }
        println!("ratio {:.2}, p999/p50 {:.1}", r.step.p50 / r.plain.p50, r.step.p999 / r.step.p50);
        return Ok(());
    }
    let report = Report {
        room: room::measure()?,
        learner: learner::measure()?,
        round_trip: round_trip::measure()?,
        training: training::measure()?,
        peers: peers::measure(command_line.peers.as_deref())?,
    };
    print!("{}", report.table());
    std::fs::write(&command_line.out, report.json()?)?;
    println!("\nThe figures are in {}.", command_line.out.display());
    Ok(())
}

/// The value below which a share of the values lies.
fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}

fn median(values: &mut [f64]) -> f64 {
    percentile(values, 0.5)
}
