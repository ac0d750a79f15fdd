//! All trainings and tests, summed up over their seeds: as JSON, and
//! as tables beside the paper's figures.

use std::{collections::BTreeMap, fs, path::Path};

use anyhow::{Context, ensure};
use learning::{run::Summary, settings::Preset};
use report::{
    confidence::{Mean, wilson_interval},
    numbers::{count, decimal, duration},
};
use serde::{Serialize, de::DeserializeOwned};
use task::{Evaluation, Scenario, seeds::MIXED};

use crate::replace_section;

/// What the paper says of its own trainings, each of 1,000 episodes, in its
/// sections 3.1, 3.2.1 and 3.2.2.
const PAPER: [Paper; 4] = [
    Paper { scenario: "empty", steps: 51_316, wall_s: Some(1_142.2) },
    Paper { scenario: "one_cylinder", steps: 41_687, wall_s: None },
    Paper { scenario: "three_cylinders", steps: 59_108, wall_s: Some(2_213.4) },
    Paper { scenario: "concave", steps: 113_839, wall_s: Some(3_518.8) },
];

#[derive(Clone, Copy, Debug, Serialize)]
struct Paper {
    scenario: &'static str,
    steps: u64,
    wall_s: Option<f64>,
}

/// Everything, as `reproduction.json` has it.
#[derive(Debug, Serialize)]
pub struct Reproduction {
    paper: [Paper; 4],
    /// One for each scenario and preset.
    trainings: Vec<Trained>,
    /// The policies that were trained in all rooms, tested in each.
    mixed: Vec<Tested>,
}

/// The trainings of a preset in a scenario.
#[derive(Debug, Serialize)]
struct Trained {
    preset: String,
    seeds: Vec<u64>,
    /// Episodes of each.
    episodes: u32,
    steps: Mean,
    wall_s: Mean,
    test: Tested,
}

/// The tests of a policy for each seed, in one scenario.
#[derive(Debug, Serialize)]
struct Tested {
    scenario: String,
    /// Episodes of all seeds.
    episodes: u32,
    successes: u32,
    success_rate: f64,
    /// Wilson's, over the episodes of all seeds.
    success_interval: Option<(f64, f64)>,
    /// The least of a seed.
    worst_success_rate: f64,
    mean_steps: Option<Mean>,
    oracle_mean_steps: Option<f64>,
    optimality_ratio: Option<Mean>,
    blocked_per_100_steps: Mean,
    collision_free_rate: Mean,
}

impl Reproduction {
    /// Reads what `reproduce.sh` has left in a directory.
    ///
    /// # Errors
    ///
    /// If there is no finished training, or a file is damaged.
    pub fn read(directory: &Path) -> anyhow::Result<Reproduction> {
        let mut summaries: BTreeMap<(String, String), Vec<(Summary, Evaluation)>> = BTreeMap::new();
        let mut mixed: BTreeMap<String, Vec<Evaluation>> = BTreeMap::new();
        let context = || directory.display().to_string();
        let mut runs = Vec::new();
        for entry in fs::read_dir(directory).with_context(context)? {
            runs.push(entry.with_context(context)?.path());
        }
        // The order of a directory is anybody's guess; that of a report is not.
        runs.sort();
        for run in runs {
            let Some(mut summary) = read_json::<Summary>(&run.join("summary.json"))? else {
                continue;
            };
            if summary.scenario == MIXED {
                for room in Scenario::ALL.map(Scenario::name) {
                    let test = read_json(&run.join(room).join("evaluation.json"))?;
                    mixed.entry(room.to_owned()).or_default().extend(test);
                }
            } else if let Some(test) = summary.evaluation.take() {
                let key = (summary.scenario.clone(), summary.preset.clone());
                summaries.entry(key).or_default().push((summary, test));
            }
        }
        ensure!(!summaries.is_empty(), "no finished training in {}", directory.display());
        let mut trainings = Vec::new();
        for scenario in Scenario::ALL.map(Scenario::name) {
            for preset in Preset::ALL {
                let key = (scenario.to_owned(), preset.to_string());
                trainings.extend(summaries.get(&key).and_then(|runs| Trained::of(runs)));
            }
        }
        let mixed =
            Scenario::ALL.iter().filter_map(|room| Tested::of(mixed.get(room.name())?)).collect();
        Ok(Reproduction { paper: PAPER, trainings, mixed })
    }

    /// Writes `reproduction.json`.
    pub fn write_json(&self, path: &Path) -> anyhow::Result<()> {
        let json = serde_json::to_string_pretty(self)? + "\n";
        fs::write(path, json).with_context(|| path.display().to_string())
    }

    /// Writes the tables into a page such as `docs/results.md`.
    pub fn write_results(&self, page: &Path) -> anyhow::Result<()> {
        replace_section(page, "trainings", &self.trainings_table())?;
        replace_section(page, "tests", &self.tests_table())?;
        replace_section(page, "mixed", &self.mixed_table())
    }

    /// Writes the short table into a page such as `README.md`.
    pub fn write_readme(&self, page: &Path) -> anyhow::Result<()> {
        replace_section(page, "results", &self.short_table())
    }

    fn of(&self, scenario: &str, preset: Preset) -> Option<&Trained> {
        let preset = preset.to_string();
        self.trainings.iter().find(|t| t.test.scenario == scenario && t.preset == preset)
    }

    fn trainings_table(&self) -> String {
        let header = [
            "scenario",
            "preset",
            "seeds",
            "episodes",
            "training steps",
            "the paper's",
            "ours / the paper's",
            "training",
            "the paper's",
        ];
        let rows = self.trainings.iter().map(|trained| {
            let paper = PAPER.iter().find(|paper| {
                trained.preset == Preset::Paper.to_string()
                    && paper.scenario == trained.test.scenario
            });
            let ratio = paper.map(|paper| trained.steps.mean / paper.steps as f64);
            vec![
                trained.test.scenario.clone(),
                trained.preset.clone(),
                trained.seeds.len().to_string(),
                count(trained.episodes.into()),
                with_interval(trained.steps, |steps| decimal(steps, 0)),
                paper.map_or_else(String::new, |paper| count(paper.steps)),
                ratio.map_or_else(String::new, |ratio| decimal(ratio, 2)),
                with_interval(trained.wall_s, duration),
                paper.and_then(|paper| paper.wall_s).map_or_else(String::new, duration),
            ]
        });
        table(&header, rows)
    }

    fn tests_table(&self) -> String {
        let mut header = Tested::HEADER.to_vec();
        header.insert(1, "preset");
        let rows = self.trainings.iter().map(|trained| {
            let mut cells = trained.test.cells();
            cells.insert(1, trained.preset.clone());
            cells
        });
        table(&header, rows)
    }

    fn mixed_table(&self) -> String {
        table(&Tested::HEADER, self.mixed.iter().map(Tested::cells))
    }

    fn short_table(&self) -> String {
        let header = [
            "scenario",
            "training steps, the paper's",
            "ours, `paper`",
            "escapes, `paper`",
            "escapes, `robust`",
            "without any blocked move",
            "steps / fewest possible",
            "escapes, one policy for all rooms",
        ];
        let rows = Scenario::ALL.map(Scenario::name).map(|scenario| {
            let stated = PAPER.iter().find(|paper| paper.scenario == scenario);
            let paper = self.of(scenario, Preset::Paper);
            let robust = self.of(scenario, Preset::Robust).map(|robust| &robust.test);
            let mixed = self.mixed.iter().find(|tested| tested.scenario == scenario);
            let escapes = |tested: Option<&Tested>| {
                tested.map_or_else(String::new, |tested| exact_percent(tested.success_rate))
            };
            vec![
                scenario.to_owned(),
                stated.map_or_else(String::new, |paper| count(paper.steps)),
                paper.map_or_else(String::new, |paper| decimal(paper.steps.mean, 0)),
                escapes(paper.map(|paper| &paper.test)),
                escapes(robust),
                robust
                    .map_or_else(String::new, |test| exact_percent(test.collision_free_rate.mean)),
                ratio(robust.and_then(|test| test.optimality_ratio)),
                escapes(mixed),
            ]
        });
        table(&header, rows.into_iter())
    }
}

impl Trained {
    fn of(runs: &[(Summary, Evaluation)]) -> Option<Trained> {
        let (first, _) = runs.first()?;
        let mean = |value: fn(&Summary) -> f64| {
            Mean::of(&runs.iter().map(|(summary, _)| value(summary)).collect::<Vec<f64>>())
        };
        let tests: Vec<Evaluation> = runs.iter().map(|(_, test)| test.clone()).collect();
        Some(Trained {
            preset: first.preset.clone(),
            seeds: runs.iter().map(|(summary, _)| summary.seed).collect(),
            episodes: first.episodes,
            steps: mean(|summary| summary.steps as f64)?,
            wall_s: mean(|summary| summary.wall_s)?,
            test: Tested::of(&tests)?,
        })
    }
}

impl Tested {
    fn of(tests: &[Evaluation]) -> Option<Tested> {
        let episodes = tests.iter().map(|test| test.episodes).sum();
        let successes = tests.iter().map(|test| test.successes).sum();
        let mean = |value: fn(&Evaluation) -> Option<f64>| {
            let values: Option<Vec<f64>> = tests.iter().map(value).collect();
            Mean::of(&values?)
        };
        let rates = tests.iter().map(|test| test.success_rate);
        Some(Tested {
            scenario: tests.first()?.scenario.clone(),
            episodes,
            successes,
            success_rate: f64::from(successes) / f64::from(episodes),
            success_interval: wilson_interval(successes, episodes),
            worst_success_rate: rates.fold(f64::INFINITY, f64::min),
            mean_steps: mean(|test| test.mean_steps),
            // The seeds of the test are the same for all, and so are the rooms.
            oracle_mean_steps: tests.first().and_then(|test| test.oracle_mean_steps),
            optimality_ratio: mean(|test| test.optimality_ratio),
            blocked_per_100_steps: mean(|test| Some(test.blocked_per_100_steps))?,
            collision_free_rate: mean(|test| Some(test.collision_free_rate))?,
        })
    }

    /// What [`Tested::cells`] are.
    const HEADER: [&str; 9] = [
        "scenario",
        "escapes",
        "95 % interval",
        "worst seed",
        "blocked moves per 100 steps",
        "episodes without any",
        "steps",
        "fewest possible",
        "steps / fewest",
    ];

    /// The scenario, and what a table says of its test.
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

/// `0.9995` as "99.95 %": the last failures count.
fn exact_percent(share: f64) -> String {
    decimal(100.0 * share, 2) + "\u{a0}%"
}

fn ratio(mean: Option<Mean>) -> String {
    mean.map_or_else(String::new, |mean| with_interval(mean, |ratio| decimal(ratio, 2)))
}

/// A mean and, where there are several seeds, half of its interval.
fn with_interval(mean: Mean, number: impl Fn(f64) -> String) -> String {
    let own = number(mean.mean);
    mean.interval.map_or(own.clone(), |(_, high)| format!("{own} ± {}", number(high - mean.mean)))
}

fn table(header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut table = format!("| {} |\n|{}\n", header.join(" | "), "---|".repeat(header.len()));
    rows.for_each(|row| table += &format!("| {} |\n", row.join(" | ")));
    table
}

/// `None` if there is no such file.
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
    fn seeds_are_summed_up_beside_the_paper() {
        let home = tempfile::tempdir().unwrap();
        for (seed, successes) in [(0, 900), (1, 1000)] {
            let out = RunDirectory::open(&home.path().join(format!("empty-{seed}"))).unwrap();
            let summary = Summary {
                scenario: "empty".into(),
                preset: "paper".into(),
                seed,
                episodes: 1000,
                steps: 51_316 + 1000 * seed,
                wall_s: 60.0,
                steps_per_s: 800.0,
                update_us: 200.0,
                evaluation: Some(evaluation("empty", successes)),
            };
            out.write_json("summary.json", &summary).unwrap();
            let mixed = home.path().join(format!("mixed-{seed}"));
            let out = RunDirectory::open(&mixed).unwrap();
            let summary = Summary { scenario: "mixed".into(), evaluation: None, ..summary };
            out.write_json("summary.json", &summary).unwrap();
            let out = RunDirectory::open(&mixed.join("concave")).unwrap();
            out.write_json("evaluation.json", &evaluation("concave", successes)).unwrap();
        }
        let reproduction = Reproduction::read(home.path()).unwrap();
        let row = |table: String| table.lines().nth(2).unwrap().to_owned();
        let trained = row(reproduction.trainings_table());
        assert!(trained.starts_with("| empty | paper | 2 | 1,000 | 51,816 ± "), "{trained}");
        assert!(trained.contains(" | 51,316 | 1.01 | 1:00 ± 0:00 | 19:02 |"), "{trained}");
        let tested = row(reproduction.tests_table());
        assert!(tested.contains("| 95.00\u{a0}% | 93.96 to 95.87 | 90.00\u{a0}% |"), "{tested}");
        assert!(row(reproduction.mixed_table()).starts_with("| concave | 95.00\u{a0}% |"));
        assert!(row(reproduction.short_table()).starts_with("| empty | 51,316 | 51,816 | 95.0"));
        let empty = tempfile::tempdir().unwrap();
        let error = Reproduction::read(empty.path()).unwrap_err().to_string();
        assert!(error.contains("no finished training"), "{error}");
    }
}
