//! Trains both presets in every scenario, and one policy for all of them, each with several seeds, over
//! DDS; tests what was trained; writes `reproduction.json`, the tables of `docs/results.md` and the
//! short one of `README.md`. `evac reproduce` starts it.

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

/// Trains and tests everything that the results show; it takes hours. What was done when it is stopped
/// is not done again.
#[derive(Parser)]
struct CommandLine {
    /// Seeds of each training, from 0
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=99))]
    seeds: u32,
    /// Where the trainings go
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
    let (mut spent, mut worked) = (Duration::ZERO, 0);
    for job in jobs.iter().filter(|job| !job.is_done()) {
        let estimate = match worked {
            0 => String::new(),
            _ => format!(", about {} min left", (spent * left / worked).as_secs() / 60 + 1),
        };
        let directory = job.directory();
        let name = directory.strip_prefix(&out).unwrap_or(directory).display();
        println!("{:3} %{estimate}: {name}", 100 * (total - left) / total);
        let started = Instant::now();
        run(job)?;
        if !job.is_done() {
            // It was interrupted, and saved its checkpoint.
            return Ok(ExitCode::from(130));
        }
        spent += started.elapsed();
        worked += job.weight;
        left -= job.weight;
    }
    let root = repository();
    let reproduction = Reproduction::read(&out)?;
    reproduction.write_json(&root.join("reproduction.json"))?;
    reproduction.write_results(&root.join("docs/results.md"))?;
    reproduction.write_readme(&root.join("README.md"))?;
    println!("The results are in docs/results.md and reproduction.json.");
    Ok(ExitCode::SUCCESS)
}

/// Runs a job by `evac`, whose output goes to a file beside its directory. Ctrl-C reaches it, too, and it
/// saves what it has.
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
        bail!("{} has ended with {status}; the whole log is {}", last_lines(&log), log.display());
    }
    Ok(())
}

fn last_lines(log: &Path) -> String {
    let text = fs::read_to_string(log).unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(20)..].join("\n")
}
