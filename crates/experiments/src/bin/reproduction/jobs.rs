//! The training runs and evaluations of the reproduction.

use std::path::{Path, PathBuf};

use learning::settings::Preset;
use task::{Scenario, seeds::MIXED};

/// Number of episodes in each evaluation.
const EVALUATION_EPISODES: &str = "2000";

/// A training run with its evaluation, or a separate evaluation of a trained model.
pub struct Job {
    /// Expected duration relative to the other jobs, used to estimate the remaining time.
    pub weight: u32,
    /// The file whose existence marks the job as done.
    file: PathBuf,
    arguments: Vec<String>,
}

impl Job {
    fn training(out: &Path, scenario: &str, preset: Preset, seed: u32) -> Job {
        let directory = out.join(format!("{scenario}-{preset}-seed{seed}"));
        let weight = match preset {
            Preset::Paper => 3,
            Preset::Robust => 10,
        };
        let arguments = [
            ["train", "--scenario", scenario],
            ["--preset", &preset.to_string(), "--seed"],
            [&seed.to_string(), "--evaluation-episodes", EVALUATION_EPISODES],
        ];
        let mut arguments: Vec<String> =
            arguments.as_flattened().iter().map(|a| a.to_string()).collect();
        arguments.extend(["--out".to_owned(), directory.display().to_string()]);
        Job { weight, file: directory.join("report.html"), arguments }
    }

    fn evaluation(model: &Path, scenario: &str) -> Job {
        let out = model.join(scenario);
        let (model, directory) = (model.display().to_string(), out.display().to_string());
        let arguments = [
            ["evaluate", "--model", &model, "--scenario"],
            [scenario, "--episodes", EVALUATION_EPISODES, "--out"],
        ];
        let mut arguments: Vec<String> =
            arguments.as_flattened().iter().map(|a| a.to_string()).collect();
        arguments.push(directory);
        Job { weight: 1, file: out.join("evaluation.json"), arguments }
    }

    /// Returns whether the job has been completed, in this or an earlier run.
    pub fn is_done(&self) -> bool {
        self.file.exists()
    }

    /// Returns the directory that contains the job's files.
    pub fn directory(&self) -> &Path {
        self.file.parent().unwrap_or(&self.file)
    }

    /// Returns the arguments for `evac`. An interrupted training run is resumed.
    pub fn arguments(&self) -> Vec<String> {
        let mut arguments = self.arguments.clone();
        if self.directory().join("checkpoint.safetensors").exists() {
            arguments.push("--resume".to_owned());
        }
        arguments
    }
}

/// Returns all jobs in the order in which they run.
pub fn all(seeds: u32, out: &Path) -> Vec<Job> {
    let mut jobs = Vec::new();
    for seed in 0..seeds {
        for scenario in Scenario::ALL.map(Scenario::name) {
            for preset in Preset::ALL {
                jobs.push(Job::training(out, scenario, preset, seed));
            }
        }
        jobs.push(Job::training(out, MIXED, Preset::Robust, seed));
        let model = out.join(format!("{MIXED}-{}-seed{seed}", Preset::Robust));
        jobs.extend(Scenario::ALL.map(|scenario| Job::evaluation(&model, scenario.name())));
    }
    jobs
}
