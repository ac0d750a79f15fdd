//! The ablation study of the preset `robust`: trains one policy for all scenarios with the preset
//! and with each variant, and evaluates it in every scenario, all in this process.
//! `launch_scripts/ablation.sh` runs this program.

mod results;
mod table;
mod variants;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use anyhow::Context;
use clap::Parser;
use experiments::{
    replace_section, repository,
    study::{evaluate_policy, train},
};
use learning::{run::RunDirectory, training::Plan};
use task::{Scenario, seeds::MIXED};

use self::{
    results::{LEVELS, Results, TrainingResult},
    variants::{Variant, variants},
};

/// Trains and evaluates variants of the preset robust and writes the results.
#[derive(Parser)]
struct CommandLine {
    /// Seed of the training runs
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of parallel training runs
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Output file (JSON); results that are already in the file are not recomputed
    #[arg(long, default_value = "results/ablation.json")]
    out: PathBuf,
    /// Markdown page whose ablation section is replaced [default: docs/results.md]
    #[arg(long)]
    results: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let command_line = CommandLine::parse();
    let variants = variants();
    let results = Mutex::new(read(&command_line.out)?);
    let next = AtomicUsize::new(0);
    let seed = command_line.seed;
    let work = || -> anyhow::Result<()> {
        while let Some(variant) = variants.get(next.fetch_add(1, Ordering::Relaxed)) {
            let is_known = |results: &Results| {
                results.get(variant.name).is_some_and(|result| result.matches(variant, seed))
            };
            if is_known(&lock(&results)) {
                continue;
            }
            let result = train_and_evaluate(variant, seed).inspect_err(|_| {
                // Keeps the other threads from starting another training run.
                next.store(variants.len(), Ordering::Relaxed);
            })?;
            eprintln!("{}: {} training steps", variant.name, result.steps);
            let mut results = lock(&results);
            results.insert(variant.name.to_owned(), result);
            write(&command_line.out, &results)?;
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..command_line.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| thread.join().expect("training does not panic"))
    })?;
    let default_page = repository().join("docs/results.md");
    let page = command_line.results.as_ref().unwrap_or(&default_page);
    replace_section(page, "ablation", &table::tables(&variants, &lock(&results)))
}

fn lock(results: &Mutex<Results>) -> std::sync::MutexGuard<'_, Results> {
    results.lock().expect("no thread panics while it holds this lock")
}

fn read(path: &Path) -> anyhow::Result<Results> {
    if !path.exists() {
        return Ok(Results::new());
    }
    let context = || format!("{}: not a result file of the ablation study", path.display());
    serde_json::from_str(&fs::read_to_string(path)?).with_context(context)
}

/// Writes the results atomically: the training runs behind them are expensive to repeat.
fn write(path: &Path, results: &Results) -> anyhow::Result<()> {
    let name = path.file_name().and_then(|name| name.to_str());
    let name = name.with_context(|| format!("--out {}: not a file name", path.display()))?;
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let directory = RunDirectory::open(parent.unwrap_or(Path::new(".")))?;
    Ok(directory.write_json(name, results)?)
}

fn train_and_evaluate(variant: &Variant, seed: u64) -> anyhow::Result<TrainingResult> {
    let plan = Plan { scenario: MIXED.to_owned(), episodes: variant.episodes, seed, rooms: 1 };
    let training = train(plan, variant.settings.clone(), variant.randomization)?;
    let mut policy = training.policy();
    let mut evaluations = BTreeMap::new();
    for level in LEVELS {
        let evaluate = |scenario| evaluate_policy(&mut policy, scenario, level, None);
        let of_level = Scenario::ALL.into_iter().map(evaluate).collect::<anyhow::Result<_>>()?;
        evaluations.insert(level.name().to_owned(), of_level);
    }
    Ok(TrainingResult {
        seed,
        episodes: variant.episodes,
        randomization: variant.randomization.name().to_owned(),
        settings: variant.settings.clone(),
        steps: training.progress.total_steps,
        evaluations,
    })
}
