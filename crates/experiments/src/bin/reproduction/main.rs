//! Trains both presets in every scenario, and one policy for all scenarios, over DDS with several
//! seeds each, and evaluates the policies. Writes `reproduction.json`, the tables in
//! `docs/results.md` and the short table in `README.md`. `evac reproduce` runs this program.

mod jobs;

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Command, ExitCode, Stdio},
    time::{Duration, Instant},
};

use anyhow::{Context, bail};
use clap::Parser;
use experiments::{repository, reproduction::Reproduction};

use self::jobs::Job;

/// Performs all training runs and evaluations behind the published results; takes an hour or more.
/// After an interruption, the same command continues with the remaining jobs.
#[derive(Parser)]
struct CommandLine {
    /// Number of seeds per preset and scenario; the first seed is 0
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=99))]
    seeds: u32,
    /// Output directory for the training runs
    #[arg(long, default_value = "runs/reproduction")]
    out: PathBuf,
}

fn main() -> anyhow::Result<ExitCode> {
    let CommandLine { seeds, out } = CommandLine::parse();
    fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
    let out = fs::canonicalize(&out)?;
    let jobs = jobs::all(seeds, &out);
    let total: u32 = jobs.iter().map(|job| job.weight).sum();
    let mut left: u32 = jobs.iter().filter(|job| !job.is_done()).map(|job| job.weight).sum();
    let (mut spent, mut completed) = (Duration::ZERO, 0);
    for job in jobs.iter().filter(|job| !job.is_done()) {
        let estimate = match completed {
            0 => String::new(),
            _ => format!(", about {} min left", (spent * left / completed).as_secs() / 60 + 1),
        };
        let directory = job.directory();
        let name = directory.strip_prefix(&out).unwrap_or(directory).display();
        println!("{:3} %{estimate}: {name}", 100 * (total - left) / total);
        let started = Instant::now();
        run(job)?;
        if !job.is_done() {
            // evac was interrupted and saved a checkpoint; 130 is the exit code for SIGINT.
            return Ok(ExitCode::from(130));
        }
        spent += started.elapsed();
        completed += job.weight;
        left -= job.weight;
    }
    let root = repository();
    let reproduction = Reproduction::read(&out)?;
    reproduction.write_json(&root.join("results/reproduction.json"))?;
    reproduction.write_results(&root.join("docs/results.md"))?;
    reproduction.write_readme(&root.join("README.md"))?;
    println!("Wrote docs/results.md, README.md and results/reproduction.json.");
    Ok(ExitCode::SUCCESS)
}

/// Runs a job with `evac` and writes its output to a log file next to the job's directory. Ctrl-C
/// also reaches `evac`, which then saves a checkpoint.
fn run(job: &Job) -> anyhow::Result<()> {
    let directory = job.directory();
    fs::create_dir_all(directory).with_context(|| directory.display().to_string())?;
    let log = directory.with_extension("log");
    let file = File::create(&log).with_context(|| log.display().to_string())?;
    let evac = std::env::current_exe()?.with_file_name("evac");
    let mut command = Command::new(&evac);
    command.args(job.arguments()).stdin(Stdio::null()).stdout(file.try_clone()?).stderr(file);
    let status = command.status().with_context(|| evac.display().to_string())?;
    if !status.success() {
        bail!("{}\nevac failed ({status}); full log: {}", last_lines(&log), log.display());
    }
    Ok(())
}

fn last_lines(log: &Path) -> String {
    let text = fs::read_to_string(log).unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(20)..].join("\n")
}
