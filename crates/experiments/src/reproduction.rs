//! Aggregates all training runs and evaluations over their seeds, as JSON and as Markdown tables
//! that compare them with the results of the paper.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, ensure};
use learning::{run::Summary, settings::Preset};
use report::{
    confidence::{Mean, wilson_interval},
    numbers::{count, decimal, duration},
};
use serde::{Serialize, de::DeserializeOwned};
use sim_node::reality::Randomization;
use task::{Evaluation, Scenario, seeds::MIXED};

use crate::replace_section;

/// The training runs that the paper reports in sections 3.1, 3.2.1 and 3.2.2, with 1,000 episodes
/// each.
const PAPER: [PaperTraining; 4] = [
    PaperTraining { scenario: "empty", steps: 51_316, wall_s: Some(1_142.2) },
    PaperTraining { scenario: "one_cylinder", steps: 41_687, wall_s: None },
    PaperTraining { scenario: "three_cylinders", steps: 59_108, wall_s: Some(2_213.4) },
    PaperTraining { scenario: "concave", steps: 113_839, wall_s: Some(3_518.8) },
];

#[derive(Clone, Copy, Debug, Serialize)]
struct PaperTraining {
    scenario: &'static str,
    steps: u64,
    wall_s: Option<f64>,
}

/// The levels of randomization at which policies are evaluated. The first is the world of the paper.
pub const LEVELS: [Randomization; 3] =
    [Randomization::None, Randomization::Mild, Randomization::Strong];

/// Returns the level of randomization in which `evac train` trains a preset by default.
pub fn training_randomization(preset: Preset) -> Randomization {
    match preset {
        Preset::Paper => Randomization::None,
        Preset::Robust => Randomization::Strong,
    }
}

/// Returns the directory of an evaluation in the directory of a training run.
pub fn evaluation_directory(run: &Path, level: Randomization, scenario: &str) -> PathBuf {
    run.join(level.name()).join(scenario)
}

/// The results of all runs, in the format of `reproduction.json`.
#[derive(Debug, Serialize)]
pub struct Reproduction {
    paper: [PaperTraining; 4],
    /// One entry per training scenario and preset; the last is the training in all scenarios.
    trainings: Vec<TrainingSummary>,
}

/// The training runs of one preset in one scenario, over all seeds.
#[derive(Debug, Serialize)]
struct TrainingSummary {
    scenario: String,
    preset: String,
    seeds: Vec<u64>,
    /// Number of episodes per training run.
    episodes: u32,
    steps: Mean,
    wall_s: Mean,
    /// One entry per level of randomization and scenario.
    evaluations: Vec<EvaluationSummary>,
}

/// The evaluations in one scenario, over the policies of all seeds.
#[derive(Debug, Serialize)]
struct EvaluationSummary {
    randomization: &'static str,
    scenario: String,
    /// Number of evaluation episodes over all seeds.
    episodes: u32,
    successes: u32,
    success_rate: f64,
    /// The 95 % Wilson interval of the success rate over the episodes of all seeds.
    success_interval: Option<(f64, f64)>,
    /// The lowest success rate of a single seed.
    worst_success_rate: f64,
    mean_steps: Option<Mean>,
    oracle_mean_steps: Option<f64>,
    optimality_ratio: Option<Mean>,
    blocked_per_100_steps: Mean,
    collision_free_rate: Mean,
}

impl Reproduction {
    /// Reads the runs that `reproduce.sh` has written to a directory.
    ///
    /// # Errors
    ///
    /// Returns an error if there is no finished training run or a file cannot be read or parsed.
    pub fn read(directory: &Path) -> anyhow::Result<Reproduction> {
        let mut summaries: BTreeMap<(String, String), Vec<(Summary, PathBuf)>> = BTreeMap::new();
        let context = || directory.display().to_string();
        let mut runs = Vec::new();
        for entry in fs::read_dir(directory).with_context(context)? {
            runs.push(entry.with_context(context)?.path());
        }
        // The order of directory entries is unspecified; the output must not depend on it.
        runs.sort();
        for run in runs {
            if let Some(summary) = read_json::<Summary>(&run.join("summary.json"))? {
                let key = (summary.scenario.clone(), summary.preset.clone());
                summaries.entry(key).or_default().push((summary, run));
            }
        }
        ensure!(!summaries.is_empty(), "no finished training run in {}", directory.display());
        let mut trainings = Vec::new();
        for scenario in Scenario::ALL.map(Scenario::name).into_iter().chain([MIXED]) {
            for preset in Preset::ALL {
                if let Some(runs) = summaries.get(&(scenario.to_owned(), preset.to_string())) {
                    trainings.extend(TrainingSummary::of(runs)?);
                }
            }
        }
        Ok(Reproduction { paper: PAPER, trainings })
    }

    /// Writes the results to a JSON file such as `reproduction.json`.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be written.
    pub fn write_json(&self, path: &Path) -> anyhow::Result<()> {
        let json = serde_json::to_string_pretty(self)? + "\n";
        fs::write(path, json).with_context(|| path.display().to_string())
    }

    /// Replaces the tables in a page such as `docs/results.md`.
    ///
    /// # Errors
    ///
    /// Returns an error if the page cannot be read or written or lacks one of the sections.
    pub fn write_results(&self, page: &Path) -> anyhow::Result<()> {
        replace_section(page, "trainings", &self.trainings_table())?;
        replace_section(page, "evaluations", &self.evaluations_table())?;
        replace_section(page, "perturbed", &self.perturbed_table())?;
        replace_section(page, "mixed", &self.mixed_table())
    }

    /// Replaces the short table in a page such as `README.md`.
    ///
    /// # Errors
    ///
    /// Returns an error if the page cannot be read or written or lacks the section.
    pub fn write_readme(&self, page: &Path) -> anyhow::Result<()> {
        replace_section(page, "results", &self.short_table())
    }

    fn training(&self, scenario: &str, preset: Preset) -> Option<&TrainingSummary> {
        let preset = preset.to_string();
        self.trainings.iter().find(|t| t.scenario == scenario && t.preset == preset)
    }

    /// Iterates over the training runs in single scenarios.
    fn specialists(&self) -> impl Iterator<Item = &TrainingSummary> {
        self.trainings.iter().filter(|training| training.scenario != MIXED)
    }

    fn trainings_table(&self) -> String {
        let header = [
            "scenario",
            "preset",
            "seeds",
            "episodes",
            "training steps",
            "training steps (paper)",
            "steps / paper's steps",
            "training time",
            "training time (paper)",
        ];
        let rows = self.trainings.iter().map(|training| {
            let paper = PAPER.iter().find(|paper| {
                training.preset == Preset::Paper.to_string() && paper.scenario == training.scenario
            });
            let ratio = paper.map(|paper| training.steps.mean / paper.steps as f64);
            vec![
                training.scenario.clone(),
                training.preset.clone(),
                training.seeds.len().to_string(),
                count(training.episodes.into()),
                with_interval(training.steps, |steps| decimal(steps, 0)),
                paper.map_or_else(String::new, |paper| count(paper.steps)),
                ratio.map_or_else(String::new, |ratio| decimal(ratio, 2)),
                with_interval(training.wall_s, duration),
                paper.and_then(|paper| paper.wall_s).map_or_else(String::new, duration),
            ]
        });
        table(&header, rows)
    }

    fn evaluations_table(&self) -> String {
        let mut header = EvaluationSummary::HEADER.to_vec();
        header.insert(1, "preset");
        let rows = self.specialists().flat_map(|training| {
            training.at(Randomization::None).map(|evaluation| {
                let mut cells = evaluation.cells();
                cells.insert(1, training.preset.clone());
                cells
            })
        });
        table(&header, rows)
    }

    /// Returns the table of the perturbed evaluations of the policies for single scenarios.
    fn perturbed_table(&self) -> String {
        let robust = self.specialists().filter(|t| t.preset == Preset::Robust.to_string());
        let evaluations = robust.flat_map(|training| {
            [Randomization::Mild, Randomization::Strong].map(|level| training.at(level))
        });
        table(&with_level(), evaluations.flatten().map(EvaluationSummary::cells_with_level))
    }

    fn mixed_table(&self) -> String {
        let mixed = self.training(MIXED, Preset::Robust);
        let evaluations = Scenario::ALL.into_iter().flat_map(|scenario| {
            let of_scenario =
                move |evaluation: &&EvaluationSummary| evaluation.scenario == scenario.name();
            mixed.into_iter().flat_map(|mixed| &mixed.evaluations).filter(of_scenario)
        });
        table(&with_level(), evaluations.map(EvaluationSummary::cells_with_level))
    }

    fn short_table(&self) -> String {
        let header = [
            "scenario",
            "success rate, `paper`",
            "success rate, one `robust` policy",
            "with `mild` perturbations",
            "with `strong` perturbations",
            "collision-free episodes",
            "steps / shortest path",
            "steps / shortest path, policy for this scenario",
        ];
        let rows = Scenario::ALL.map(Scenario::name).map(|scenario| {
            let evaluation = |training: &str, preset, level| {
                let training = self.training(training, preset)?;
                training.at(level).find(|evaluation| evaluation.scenario == scenario)
            };
            let success_rate = |evaluation: Option<&EvaluationSummary>| {
                evaluation.map_or_else(String::new, |e| exact_percent(e.success_rate))
            };
            let [none, mild, strong] = LEVELS.map(|level| evaluation(MIXED, Preset::Robust, level));
            let specialist = evaluation(scenario, Preset::Robust, Randomization::None);
            vec![
                scenario.to_owned(),
                success_rate(evaluation(scenario, Preset::Paper, Randomization::None)),
                success_rate(none),
                success_rate(mild),
                success_rate(strong),
                none.map_or_else(String::new, |e| exact_percent(e.collision_free_rate.mean)),
                ratio(none.and_then(|evaluation| evaluation.optimality_ratio)),
                ratio(specialist.and_then(|evaluation| evaluation.optimality_ratio)),
            ]
        });
        table(&header, rows.into_iter())
    }
}

impl TrainingSummary {
    /// Aggregates the training runs of one preset in one scenario, given with their directories;
    /// `None` if there are none.
    fn of(runs: &[(Summary, PathBuf)]) -> anyhow::Result<Option<TrainingSummary>> {
        let Some((first, _)) = runs.first() else {
            return Ok(None);
        };
        let mean = |value: fn(&Summary) -> f64| {
            Mean::of(&runs.iter().map(|(summary, _)| value(summary)).collect::<Vec<f64>>())
        };
        let (Some(steps), Some(wall_s)) =
            (mean(|summary| summary.steps as f64), mean(|summary| summary.wall_s))
        else {
            return Ok(None);
        };
        let mut evaluations = Vec::new();
        for level in LEVELS {
            for scenario in Scenario::ALL.map(Scenario::name) {
                let mut of_seeds = Vec::new();
                for (_, run) in runs {
                    let directory = evaluation_directory(run, level, scenario);
                    of_seeds.extend(read_json::<Evaluation>(&directory.join("evaluation.json"))?);
                }
                evaluations.extend(EvaluationSummary::of(level, &of_seeds));
            }
        }
        Ok(Some(TrainingSummary {
            scenario: first.scenario.clone(),
            preset: first.preset.clone(),
            seeds: runs.iter().map(|(summary, _)| summary.seed).collect(),
            episodes: first.episodes,
            steps,
            wall_s,
            evaluations,
        }))
    }

    /// Iterates over the evaluations at a level of randomization, one per scenario.
    fn at(&self, level: Randomization) -> impl Iterator<Item = &EvaluationSummary> {
        self.evaluations.iter().filter(move |evaluation| evaluation.randomization == level.name())
    }
}

impl EvaluationSummary {
    /// Aggregates the evaluations of all seeds in one scenario; `None` if there are none.
    fn of(level: Randomization, evaluations: &[Evaluation]) -> Option<EvaluationSummary> {
        let episodes = evaluations.iter().map(|evaluation| evaluation.episodes).sum();
        let successes = evaluations.iter().map(|evaluation| evaluation.successes).sum();
        let mean = |value: fn(&Evaluation) -> Option<f64>| {
            let values: Option<Vec<f64>> = evaluations.iter().map(value).collect();
            Mean::of(&values?)
        };
        let rates = evaluations.iter().map(|evaluation| evaluation.success_rate);
        let first = evaluations.first()?;
        Some(EvaluationSummary {
            randomization: level.name(),
            scenario: first.scenario.clone(),
            episodes,
            successes,
            success_rate: f64::from(successes) / f64::from(episodes),
            success_interval: wilson_interval(successes, episodes),
            worst_success_rate: rates.fold(f64::INFINITY, f64::min),
            mean_steps: mean(|evaluation| evaluation.mean_steps),
            // All evaluations use the same seed and therefore have the same shortest paths.
            oracle_mean_steps: first.oracle_mean_steps,
            optimality_ratio: mean(|evaluation| evaluation.optimality_ratio),
            blocked_per_100_steps: mean(|evaluation| Some(evaluation.blocked_per_100_steps))?,
            collision_free_rate: mean(|evaluation| Some(evaluation.collision_free_rate))?,
        })
    }

    /// The headings of the columns that [`EvaluationSummary::cells`] returns.
    const HEADER: [&str; 9] = [
        "scenario",
        "success rate",
        "95 % interval",
        "worst seed",
        "blocked moves per 100 steps",
        "collision-free episodes",
        "mean steps",
        "shortest path",
        "steps / shortest path",
    ];

    /// Returns the cells of a table row, including the level of randomization.
    fn cells_with_level(&self) -> Vec<String> {
        let mut cells = self.cells();
        cells.insert(1, self.randomization.to_owned());
        cells
    }

    /// Returns the cells of a table row.
    fn cells(&self) -> Vec<String> {
        let interval = self.success_interval;
        vec![
            self.scenario.clone(),
            exact_percent(self.success_rate),
            interval.map_or_else(String::new, |(low, high)| {
                format!("{} to {}", decimal(100.0 * low, 2), decimal(100.0 * high, 2))
            }),
            exact_percent(self.worst_success_rate),
            with_interval(self.blocked_per_100_steps, |blocked| decimal(blocked, 2)),
            with_interval(self.collision_free_rate, |free| decimal(100.0 * free, 1)) + "\u{a0}%",
            self.mean_steps.map_or_else(String::new, |m| with_interval(m, |m| decimal(m, 2))),
            self.oracle_mean_steps.map_or_else(String::new, |steps| decimal(steps, 2)),
            ratio(self.optimality_ratio),
        ]
    }
}

/// Returns the headings of the columns that [`EvaluationSummary::cells_with_level`] returns.
fn with_level() -> Vec<&'static str> {
    let mut header = EvaluationSummary::HEADER.to_vec();
    header.insert(1, "perturbations");
    header
}

/// Formats a share with two decimals, `0.9995` as "99.95 %", so that rare failures stay visible.
fn exact_percent(share: f64) -> String {
    decimal(100.0 * share, 2) + "\u{a0}%"
}

fn ratio(mean: Option<Mean>) -> String {
    mean.map_or_else(String::new, |mean| with_interval(mean, |ratio| decimal(ratio, 2)))
}

/// Formats a mean with the half-width of its confidence interval; a single seed has no interval.
fn with_interval(mean: Mean, number: impl Fn(f64) -> String) -> String {
    let text = number(mean.mean);
    match mean.interval {
        Some((_, high)) => format!("{text} ± {}", number(high - mean.mean)),
        None => text,
    }
}

fn table(header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut table = format!("| {} |\n|{}\n", header.join(" | "), "---|".repeat(header.len()));
    rows.for_each(|row| table += &format!("| {} |\n", row.join(" | ")));
    table
}

/// Reads and parses a file; `None` if it does not exist.
fn read_json<T: DeserializeOwned>(path: &Path) -> anyhow::Result<Option<T>> {
    if !path.exists() {
        return Ok(None);
    }
    let context = || path.display().to_string();
    let text = fs::read_to_string(path).with_context(context)?;
    Ok(Some(serde_json::from_str(&text).with_context(context)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use learning::run::RunDirectory;

    fn evaluation(scenario: &str, successes: u32) -> Evaluation {
        Evaluation {
            scenario: scenario.into(),
            episodes: 1000,
            successes,
            success_rate: f64::from(successes) / 1000.0,
            max_steps: 200,
            seed: 1,
            mean_steps: Some(f64::from(successes) / 100.0),
            oracle_mean_steps: Some(9.0),
            optimality_ratio: Some(1.2),
            blocked_per_100_steps: 0.5,
            collision_free_rate: 0.97,
        }
    }

    #[test]
    fn tables_aggregate_the_seeds_and_show_the_results_of_the_paper() {
        let home = tempfile::tempdir().unwrap();
        for (seed, successes) in [(0, 900), (1, 1000)] {
            let summary = Summary {
                scenario: "empty".into(),
                preset: "paper".into(),
                seed,
                episodes: 1000,
                steps: 51_316 + 1000 * seed,
                wall_s: 60.0,
                steps_per_s: 800.0,
                update_us: 200.0,
                evaluation: None,
            };
            let mixed =
                Summary { scenario: "mixed".into(), preset: "robust".into(), ..summary.clone() };
            let robust = Summary { preset: "robust".into(), ..summary.clone() };
            for (run, levels, scenario) in [
                (summary, &LEVELS[..1], "empty"),
                (robust, &LEVELS[..], "empty"),
                (mixed, &LEVELS[..], "concave"),
            ] {
                let name = format!("{}-{}-{seed}", run.scenario, run.preset);
                let directory = home.path().join(name);
                RunDirectory::open(&directory).unwrap().write_json("summary.json", &run).unwrap();
                for level in levels {
                    let directory = evaluation_directory(&directory, *level, scenario);
                    let directory = RunDirectory::open(&directory).unwrap();
                    let evaluation = evaluation(scenario, successes);
                    directory.write_json("evaluation.json", &evaluation).unwrap();
                }
            }
        }
        let reproduction = Reproduction::read(home.path()).unwrap();
        let row = |table: String| table.lines().nth(2).unwrap().to_owned();
        let training = row(reproduction.trainings_table());
        assert!(training.starts_with("| empty | paper | 2 | 1,000 | 51,816 ± "), "{training}");
        assert!(training.contains(" | 51,316 | 1.01 | 1:00 ± 0:00 | 19:02 |"), "{training}");
        let result = row(reproduction.evaluations_table());
        assert!(result.contains("| 95.00\u{a0}% | 93.96 to 95.87 | 90.00\u{a0}% |"), "{result}");
        let perturbed = row(reproduction.perturbed_table());
        assert!(perturbed.starts_with("| empty | mild | 95.00\u{a0}% |"), "{perturbed}");
        assert_eq!(reproduction.mixed_table().lines().count(), 2 + LEVELS.len());
        assert!(row(reproduction.mixed_table()).starts_with("| concave | none | 95.00\u{a0}% |"));
        assert!(row(reproduction.short_table()).starts_with("| empty | 95.00\u{a0}% |  |"));
        let empty = tempfile::tempdir().unwrap();
        let error = Reproduction::read(empty.path()).unwrap_err().to_string();
        assert!(error.contains("no finished training"), "{error}");
    }
}
