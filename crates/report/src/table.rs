//! The tables on the page: the training run and its evaluation.

use super::confidence::wilson_interval;
use super::numbers::{count, decimal, duration, percent};
use super::run_summary::RunSummary;
use learning::record::EpisodeRecord;
use task::Evaluation;

/// A row of a table.
#[derive(Debug, PartialEq)]
pub(super) struct Row {
    pub name: &'static str,
    pub value: String,
    /// Explanation of the value; may be empty.
    pub note: String,
}

impl Row {
    fn new(name: &'static str, value: impl Into<String>, note: impl Into<String>) -> Self {
        Self { name, value: value.into(), note: note.into() }
    }
}

/// Returns the rows about the training run: configuration, progress and speed.
pub(super) fn run_rows(run: &RunSummary, records: &[EpisodeRecord]) -> Vec<Row> {
    let completed = records.len() as u64;
    let successes = records.iter().filter(|record| record.terminated).count() as u64;
    let planned = if completed < run.episodes.into() {
        format!("of {}", count(run.episodes.into()))
    } else {
        String::new()
    };
    let update = run.update_us.map_or("–".into(), |update| format!("{} µs", decimal(update, 0)));
    vec![
        Row::new("Scenario", run.scenario, ""),
        Row::new("Preset", run.preset, ""),
        Row::new("Seed", run.seed.to_string(), ""),
        Row::new("Training episodes", count(completed), planned),
        Row::new("Successful training episodes", count(successes), ""),
        Row::new("Steps", count(run.steps), ""),
        Row::new("Wall time", duration(run.wall_s), ""),
        Row::new("Steps per second", decimal(run.steps_per_s, 0), ""),
        Row::new("Mean update time", update, ""),
    ]
}

/// Returns the rows about the evaluation of the policy.
pub(super) fn evaluation_rows(evaluation: &Evaluation) -> Vec<Row> {
    let mut rows = vec![
        Row::new("Scenario", &*evaluation.scenario, ""),
        Row::new(
            "Evaluation episodes",
            count(evaluation.episodes.into()),
            format!(
                "evaluation seed {}, at most {} steps each, greedy policy (no exploration)",
                evaluation.seed,
                count(evaluation.max_steps.into())
            ),
        ),
    ];
    if let Some((low, high)) = wilson_interval(evaluation.successes, evaluation.episodes) {
        rows.push(Row::new(
            "Success rate",
            percent(evaluation.success_rate),
            format!(
                "{} of {} episodes; 95\u{a0}% confidence interval (Wilson): {} to {}",
                count(evaluation.successes.into()),
                count(evaluation.episodes.into()),
                percent(low),
                percent(high)
            ),
        ));
    }
    rows.push(match evaluation.mean_steps {
        Some(steps) => {
            Row::new("Steps to the exit", decimal(steps, 1), "mean over the successful episodes")
        }
        None => Row::new("Steps to the exit", "–", "no episode succeeded"),
    });
    if let Some(steps) = evaluation.oracle_mean_steps {
        rows.push(Row::new(
            "Full-knowledge shortest path",
            decimal(steps, 1),
            "mean steps over all evaluation episodes, given full knowledge of the room",
        ));
    }
    if let Some(ratio) = evaluation.optimality_ratio {
        rows.push(Row::new(
            "Steps / shortest path",
            decimal(ratio, 2),
            "steps of the successful episodes divided by the shortest paths of the same episodes; 1 is \
             optimal",
        ));
    }
    rows.extend([
        Row::new(
            "Blocked moves per 100 steps",
            decimal(evaluation.blocked_per_100_steps, 2),
            "over all episodes, including failed ones",
        ),
        Row::new(
            "Collision-free episodes",
            percent(evaluation.collision_free_rate),
            "share of episodes without a blocked move",
        ),
    ]);
    rows
}
