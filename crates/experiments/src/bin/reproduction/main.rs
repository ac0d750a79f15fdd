//! Trains both presets in every scenario, and one policy for all scenarios, with several seeds
//! each, and evaluates the policies with and without perturbations. Writes `reproduction.json`, the
//! tables in `docs/results.md` and the short table in `README.md`. `evac reproduce` runs this
//! program.
//!
//! All training runs are in this process. The same training run over DDS gives the same weights, to
//! the last bit. One of them is repeated over DDS to check this, and for the robustness of its
//! policy.

mod jobs;
mod over_dds;

use std::{
    fs,
    path::PathBuf,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    time::Instant,
};

use anyhow::Context;
use clap::Parser;
use experiments::{replace_section, repository, reproduction::Reproduction};

use self::jobs::Job;

/// Performs all training runs and evaluations behind the published results; takes an hour or so.
/// After an interruption, the same command continues with the remaining training runs.
#[derive(Parser)]
struct CommandLine {
    /// Number of seeds per preset and scenario; the first seed is 0
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=99))]
    seeds: u32,
    /// Number of parallel training runs
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: u32,
    /// Output directory
    #[arg(long, default_value = "runs/reproduction")]
    out: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let CommandLine { seeds, jobs: threads, out } = CommandLine::parse();
    fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
    let jobs: Vec<Job> = jobs::all(seeds, &out).into_iter().filter(|job| !job.is_done()).collect();
    let total: u32 = jobs.iter().map(Job::weight).sum();
    let (next, done, started) = (AtomicUsize::new(0), Mutex::new(0), Instant::now());
    let work = || -> anyhow::Result<()> {
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            // After an error, the other threads start no further training run.
            job.run()
                .inspect_err(|_| next.store(jobs.len(), Ordering::Relaxed))
                .with_context(|| job.name())?;
            let mut done = done.lock().expect("no thread panics while it holds this lock");
            *done += job.weight();
            let left = started.elapsed() * (total - *done) / *done;
            let percent = 100 * *done / total;
            println!("{percent:3} %, about {} min left: {}", left.as_secs() / 60 + 1, job.name());
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| thread.join().expect("training does not panic"))
    })?;
    // The first job trains the policy for all scenarios with seed 0.
    let first = jobs::all(1, &out).swap_remove(0);
    let robustness = over_dds::robustness(&out, &first.model())?;
    let root = repository();
    let results = root.join("docs/results.md");
    replace_section(&results, "robustness", &over_dds::table(&robustness)?)?;
    for (from, to) in [
        ("robustness.json", "results/robustness.json"),
        ("figures/robustness.svg", "docs/images/robustness-concave.svg"),
    ] {
        fs::copy(robustness.join(from), root.join(to)).with_context(|| to.to_owned())?;
    }
    let reproduction = Reproduction::read(&out)?;
    reproduction.write_json(&root.join("results/reproduction.json"))?;
    reproduction.write_results(&results)?;
    reproduction.write_readme(&root.join("README.md"))?;
    println!(
        "Wrote docs/results.md, README.md, docs/images/robustness-concave.svg, \
         results/reproduction.json and results/robustness.json."
    );
    Ok(())
}
