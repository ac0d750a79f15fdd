//! What each ingredient of the preset `robust` is good for: trainings without it, in every scenario,
//! in one process. `launch_scripts/ablation.sh` runs it.

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
use experiments::{Room, Silent, replace_section, repository};
use learning::{
    evaluation::{TestPlan, run_test},
    run::RunDirectory,
    settings::Settings,
    training::{Plan, Training},
};
use serde::{Deserialize, Serialize};
use sim_node::world::WorldSettings;
use task::{Evaluation, Scenario};

use self::variants::{Variant, variants};

/// The test of a training; its rooms are those of `evaluate.sh`.
const TEST_EPISODES: u32 = 2000;
const TEST_SEED: u64 = 1;
const TEST_STEPS: u32 = 200;

/// Trains variants of the preset robust in every scenario, and writes what they reach.
#[derive(Parser)]
struct CommandLine {
    /// The seed of the trainings
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Trainings at the same time
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Where the figures go, as JSON; what is there already is not done again
    #[arg(long, default_value = "ablation.json")]
    out: PathBuf,
    /// The page that holds the tables, between two comments [default: docs/results.md]
    #[arg(long)]
    results: Option<PathBuf>,
}

/// What every variant has reached, by its name and the scenario.
type Figures = BTreeMap<String, BTreeMap<String, Reached>>;

/// The test of a training, and what the training was.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Reached {
    seed: u64,
    episodes: u32,
    settings: Settings,
    evaluation: Evaluation,
}

impl Reached {
    fn is_of(&self, variant: &Variant, seed: u64) -> bool {
        let Reached { settings, .. } = self;
        (self.seed, self.episodes, settings) == (seed, variant.episodes, &variant.settings)
    }
}

fn main() -> anyhow::Result<()> {
    let command_line = CommandLine::parse();
    let variants = variants();
    let figures = Mutex::new(read(&command_line.out)?);
    let jobs: Vec<(&Variant, Scenario)> = variants
        .iter()
        .flat_map(|variant| Scenario::ALL.map(|scenario| (variant, scenario)))
        .collect();
    let next = AtomicUsize::new(0);
    let seed = command_line.seed;
    let work = || -> anyhow::Result<()> {
        while let Some((variant, scenario)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = scenario.name();
            let is_known = |figures: &Figures| {
                let reached = figures.get(variant.name).and_then(|variant| variant.get(name));
                reached.is_some_and(|reached| reached.is_of(variant, seed))
            };
            if is_known(&lock(&figures)) {
                continue;
            }
            let evaluation = train_and_test(variant, name, seed).inspect_err(|_| {
                // Nobody begins another one.
                next.store(jobs.len(), Ordering::Relaxed);
            })?;
            eprintln!(
                "{}, {name}: {:.2} % escape, {:.2} blocked per 100 steps",
                variant.name,
                100.0 * evaluation.success_rate,
                evaluation.blocked_per_100_steps
            );
            let (episodes, settings) = (variant.episodes, variant.settings.clone());
            let reached = Reached { seed, episodes, settings, evaluation };
            let mut figures = lock(&figures);
            figures.entry(variant.name.to_owned()).or_default().insert(name.to_owned(), reached);
            write(&command_line.out, &figures)?;
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..command_line.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| thread.join().expect("no training panics"))
    })?;
    let results = repository().join("docs/results.md");
    let page = command_line.results.as_ref().unwrap_or(&results);
    replace_section(page, "ablation", &table::tables(&variants, &lock(&figures)))
}

fn lock(figures: &Mutex<Figures>) -> std::sync::MutexGuard<'_, Figures> {
    figures.lock().expect("nobody panics with it")
}

fn read(path: &Path) -> anyhow::Result<Figures> {
    if !path.exists() {
        return Ok(Figures::new());
    }
    let context = || format!("{} is not from here", path.display());
    serde_json::from_str(&fs::read_to_string(path)?).with_context(context)
}

/// Whole or not at all: what was reached so far took long.
fn write(path: &Path, figures: &Figures) -> anyhow::Result<()> {
    let name = path.file_name().and_then(|name| name.to_str());
    let name = name.with_context(|| format!("{} is no name of a file", path.display()))?;
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let directory = RunDirectory::open(parent.unwrap_or(Path::new(".")))?;
    Ok(directory.write_json(name, figures)?)
}

fn train_and_test(variant: &Variant, scenario: &str, seed: u64) -> anyhow::Result<Evaluation> {
    let plan = Plan { scenario: scenario.to_owned(), episodes: variant.episodes, seed, rooms: 1 };
    let mut room = Room::new(WorldSettings::default());
    let mut training = Training::new(plan, variant.settings.clone())?;
    training.run(std::slice::from_mut(&mut room), &mut Silent)?;
    let test = TestPlan {
        scenario: scenario.to_owned(),
        episodes: TEST_EPISODES,
        seed: TEST_SEED,
        max_steps: TEST_STEPS,
    };
    let tested = run_test(&test, &mut training.policy()?, &mut room, &mut Silent)?;
    Ok(test.evaluation(&tested, None))
}
