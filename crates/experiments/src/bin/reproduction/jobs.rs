//! The training runs of the reproduction, each followed by the evaluations of its policy.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::OnceLock,
};

use experiments::{
    reproduction::{LEVELS, evaluation_directory, training_randomization},
    study::{EVALUATION_EPISODES, EVALUATION_SEED, evaluate_policy, train},
};
use learning::{
    checkpoint::model_bytes,
    run::{RunDirectory, Summary},
    settings::{Preset, Settings},
    training::Plan,
};
use serde::{Deserialize, Serialize};
use sim_node::world::{World, WorldSettings, shortest_path_length};
use task::{
    Scenario,
    seeds::{MIXED, Purpose, episode_seed},
};

/// The file with the settings of a completed job.
const SETTINGS: &str = "settings.json";

/// What the results of a job depend on, besides its name.
#[derive(PartialEq, Serialize, Deserialize)]
struct JobSettings {
    episodes: u32,
    /// The randomization of the training.
    randomization: String,
    settings: Settings,
}

/// A training run and the evaluations of its policy.
pub struct Job {
    scenario: &'static str,
    preset: Preset,
    seed: u64,
    directory: PathBuf,
}

impl Job {
    /// Returns the name of the job, which is the name of its directory.
    pub fn name(&self) -> String {
        format!("{}-{}-seed{}", self.scenario, self.preset, self.seed)
    }

    /// Returns the path of the trained model.
    pub fn model(&self) -> PathBuf {
        self.directory.join(RunDirectory::MODEL)
    }

    /// Returns the expected duration relative to the other jobs.
    pub fn weight(&self) -> u32 {
        match self.preset {
            Preset::Paper => 1,
            Preset::Robust => 8,
        }
    }

    /// Returns whether the job was completed with the same settings, in this or an earlier run.
    pub fn is_done(&self) -> bool {
        let written = fs::read(self.directory.join(SETTINGS)).ok();
        let written = written.and_then(|json| serde_json::from_slice::<JobSettings>(&json).ok());
        written == Some(self.settings())
    }

    fn settings(&self) -> JobSettings {
        JobSettings {
            episodes: self.preset.episodes(),
            randomization: training_randomization(self.preset).name().to_owned(),
            settings: self.preset.settings(),
        }
    }

    /// Trains the policy and evaluates it. Writes the model, the evaluations, `summary.json` and, as
    /// the last file, the settings.
    ///
    /// # Errors
    ///
    /// Returns an error if training diverges or a file cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        let plan = Plan {
            scenario: self.scenario.to_owned(),
            episodes: self.preset.episodes(),
            seed: self.seed,
            rooms: 1,
        };
        let level = training_randomization(self.preset);
        let training = train(plan, self.preset.settings(), level)?;
        let scenarios = match self.scenario {
            MIXED => Scenario::ALL.to_vec(),
            scenario => vec![scenario.parse()?],
        };
        let levels = match self.preset {
            Preset::Paper => &LEVELS[..1],
            Preset::Robust => &LEVELS[..],
        };
        let directory = RunDirectory::open(&self.directory)?;
        directory.write(RunDirectory::MODEL, &model_bytes(training.learner().network())?)?;
        let mut policy = training.policy();
        for level in levels {
            for scenario in &scenarios {
                let shortest = shortest_paths(*scenario)?;
                let evaluation = evaluate_policy(&mut policy, *scenario, *level, Some(shortest))?;
                let directory = evaluation_directory(&self.directory, *level, scenario.name());
                RunDirectory::open(&directory)?.write_json("evaluation.json", &evaluation)?;
            }
        }
        let summary = Summary {
            scenario: self.scenario.to_owned(),
            preset: self.preset.to_string(),
            seed: self.seed,
            episodes: training.plan.episodes,
            steps: training.progress.total_steps,
            wall_s: training.progress.wall.as_secs_f64(),
            steps_per_s: training.steps_per_s(),
            update_us: training.update_us(),
            evaluation: None,
        };
        directory.write_json("summary.json", &summary)?;
        Ok(directory.write_json(SETTINGS, &self.settings())?)
    }
}

/// Returns the lengths of the full-knowledge shortest paths of the evaluation episodes, in steps.
/// They are computed once per scenario.
fn shortest_paths(scenario: Scenario) -> anyhow::Result<&'static [Option<u32>]> {
    static COMPUTED: [OnceLock<Vec<Option<u32>>>; Scenario::ALL.len()] =
        [const { OnceLock::new() }; Scenario::ALL.len()];
    let computed = &COMPUTED[scenario as usize];
    if let Some(lengths) = computed.get() {
        return Ok(lengths);
    }
    let mut world = World::new(WorldSettings::default(), scenario, 0)?;
    let length = |episode| {
        let seed = episode_seed(Purpose::Evaluation, EVALUATION_SEED, episode);
        world.reset(Some(seed), Some(scenario))?;
        Ok(shortest_path_length(&world))
    };
    let lengths = (0..EVALUATION_EPISODES).map(length).collect::<anyhow::Result<Vec<_>>>()?;
    Ok(computed.get_or_init(|| lengths))
}

/// Returns all jobs in the order in which they run.
pub fn all(seeds: u32, out: &Path) -> Vec<Job> {
    let mut jobs = Vec::new();
    for seed in 0..seeds.into() {
        let mut add = |scenario, preset| {
            let mut job = Job { scenario, preset, seed, directory: PathBuf::new() };
            job.directory = out.join(job.name());
            jobs.push(job);
        };
        add(MIXED, Preset::Robust);
        for scenario in Scenario::ALL.map(Scenario::name) {
            Preset::ALL.into_iter().for_each(|preset| add(scenario, preset));
        }
    }
    jobs
}
