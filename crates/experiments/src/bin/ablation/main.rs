//! The ablation study of the preset `robust`: trains and evaluates the preset and its variants in
//! every scenario, all in this process. `launch_scripts/ablation.sh` runs this program.

mod results;
mod table;
mod variants;

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use anyhow::Context;
use clap::Parser;
use experiments::{NullListener, Room, replace_section, repository};
use learning::{
    evaluation::{EvaluationPlan, evaluate},
    run::RunDirectory,
    training::{Plan, Training},
};
use sim_node::world::WorldSettings;
use task::{Evaluation, Scenario};

use self::{
    results::{Results, TrainingResult},
    variants::{Variant, variants},
};

/// The evaluation after each training run. The seed and the step limit are the defaults of
/// `evaluate.sh`.
const EVALUATION_EPISODES: u32 = 2000;
const EVALUATION_SEED: u64 = 1;
const EVALUATION_STEPS: u32 = 200;

/// Trains and evaluates variants of the preset robust in every scenario and writes the results.
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
    let jobs: Vec<(&Variant, Scenario)> = variants
        .iter()
        .flat_map(|variant| Scenario::ALL.map(|scenario| (variant, scenario)))
        .collect();
    let next = AtomicUsize::new(0);
    let seed = command_line.seed;
    let work = || -> anyhow::Result<()> {
        while let Some((variant, scenario)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = scenario.name();
            let is_known = |results: &Results| {
                let result = results.get(variant.key).and_then(|variant| variant.get(name));
                result.is_some_and(|result| result.matches(variant, seed))
            };
            if is_known(&lock(&results)) {
                continue;
            }
            let evaluation = train_and_evaluate(variant, name, seed).inspect_err(|_| {
                // Keeps the other threads from starting another training run.
                next.store(jobs.len(), Ordering::Relaxed);
            })?;
            eprintln!(
                "{}, {name}: success rate {:.2} %, {:.2} blocked moves per 100 steps",
                variant.label,
                100.0 * evaluation.success_rate,
                evaluation.blocked_per_100_steps
            );
            let (episodes, settings) = (variant.episodes, variant.settings.clone());
            let result = TrainingResult { seed, episodes, settings, evaluation };
            let mut results = lock(&results);
            results.entry(variant.key.to_owned()).or_default().insert(name.to_owned(), result);
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

fn train_and_evaluate(variant: &Variant, scenario: &str, seed: u64) -> anyhow::Result<Evaluation> {
    let plan = Plan { scenario: scenario.to_owned(), episodes: variant.episodes, seed, rooms: 1 };
    let mut room = Room::new(WorldSettings::default());
    let mut training = Training::new(plan, variant.settings.clone())?;
    training.run(std::slice::from_mut(&mut room), &mut NullListener)?;
    let plan = EvaluationPlan {
        scenario: scenario.to_owned(),
        episodes: EVALUATION_EPISODES,
        seed: EVALUATION_SEED,
        max_steps: EVALUATION_STEPS,
    };
    let episodes = evaluate(&plan, &mut training.policy(), &mut room, &mut NullListener)?;
    Ok(plan.evaluation(&episodes, None))
}
