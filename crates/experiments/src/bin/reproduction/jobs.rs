//! What there is to train and to test.

use std::path::{Path, PathBuf};

use learning::settings::Preset;
use task::{Scenario, seeds::MIXED};

/// Episodes of each test.
const TEST_EPISODES: &str = "2000";

/// A training with its test, or another test of what was trained.
pub struct Job {
    /// About its share of the time.
    pub weight: u32,
    /// The file that it leaves when it is done.
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
            [&seed.to_string(), "--evaluation-episodes", TEST_EPISODES],
        ];
        let mut arguments: Vec<String> =
            arguments.as_flattened().iter().map(|a| a.to_string()).collect();
        arguments.extend(["--out".to_owned(), directory.display().to_string()]);
        Job { weight, file: directory.join("report.html"), arguments }
    }

    fn test(model: &Path, scenario: &str) -> Job {
        let out = model.join(scenario);
        let (model, directory) = (model.display().to_string(), out.display().to_string());
        let arguments = [
            ["evaluate", "--model", &model, "--scenario"],
            [scenario, "--episodes", TEST_EPISODES, "--out"],
        ];
        let mut arguments: Vec<String> =
            arguments.as_flattened().iter().map(|a| a.to_string()).collect();
        arguments.push(directory);
        Job { weight: 1, file: out.join("evaluation.json"), arguments }
    }

    /// Whether it was done.
    pub fn is_done(&self) -> bool {
        self.file.exists()
    }

    /// Where its files go.
    pub fn directory(&self) -> &Path {
        self.file.parent().unwrap_or(&self.file)
    }

    /// The arguments of `evac`; a training that was stopped goes on.
    pub fn arguments(&self) -> Vec<String> {
        let mut arguments = self.arguments.clone();
        if self.directory().join("checkpoint.safetensors").exists() {
            arguments.push("--resume".to_owned());
        }
        arguments
    }
}

/// All jobs, in their order.
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
        jobs.extend(Scenario::ALL.map(|scenario| Job::test(&model, scenario.name())));
    }
    jobs
}
