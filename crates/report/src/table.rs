//! The facts of the run and the results of the test, in the order in which one asks for them.

use super::RunFacts;
use super::confidence::wilson_interval;
use super::numbers::{count, decimal, duration, percent};
use learning::record::EpisodeRecord;
use task::Evaluation;

/// A line of a table.
#[derive(Debug, PartialEq)]
pub(super) struct Row {
    pub name: &'static str,
    pub value: String,
    /// What makes the value mean something; may be empty.
    pub note: String,
}

impl Row {
    fn new(name: &'static str, value: impl Into<String>, note: impl Into<String>) -> Self {
        Self { name, value: value.into(), note: note.into() }
    }
}

/// What was run, and how long it took.
pub(super) fn run(run: &RunFacts, records: &[EpisodeRecord]) -> Vec<Row> {
    let done = records.len() as u64;
    let escapes = records.iter().filter(|record| record.terminated).count() as u64;
    let planned = if done < run.episodes.into() {
        format!("of {}", count(run.episodes.into()))
    } else {
        String::new()
    };
    let update = run.update_us.map_or("–".into(), |update| format!("{} µs", decimal(update, 0)));
    vec![
        Row::new("Scenario", run.scenario, ""),
        Row::new("Preset", run.preset, ""),
        Row::new("Seed", run.seed.to_string(), ""),
        Row::new("Episodes", count(done), planned),
        Row::new("Escapes in training", count(escapes), ""),
        Row::new("Steps", count(run.steps), ""),
        Row::new("Wall time", duration(run.wall_s), ""),
        Row::new("Steps per second", decimal(run.steps_per_s, 0), ""),
        Row::new("One update", update, ""),
    ]
}

/// What the trained policy can do.
pub(super) fn test(test: &Evaluation) -> Vec<Row> {
    let mut rows = vec![
        Row::new("Scenario", &*test.scenario, ""),
        Row::new(
            "Test episodes",
            count(test.episodes.into()),
            format!(
                "test seed {}, at most {} steps each, without exploration",
                test.seed,
                count(test.max_steps.into())
            ),
        ),
    ];
    if let Some((low, high)) = wilson_interval(test.successes, test.episodes) {
        rows.push(Row::new(
            "Escaped",
            percent(test.success_rate),
            format!(
                "{} of {}; 95\u{a0}% confidence (Wilson): {} to {}",
                count(test.successes.into()),
                count(test.episodes.into()),
                percent(low),
                percent(high)
            ),
        ));
    }
    rows.push(match test.mean_steps {
        Some(steps) => Row::new("Steps to the exit", decimal(steps, 1), "mean of the escapes"),
        None => Row::new("Steps to the exit", "–", "no episode ended at the exit"),
    });
    if let Some(steps) = test.oracle_mean_steps {
        rows.push(Row::new(
            "Fewest possible steps",
            decimal(steps, 1),
            "mean of all test episodes, with full knowledge of the room",
        ));
    }
    if let Some(ratio) = test.optimality_ratio {
        rows.push(Row::new(
            "Optimality ratio",
            decimal(ratio, 2),
            "steps of the escapes over their fewest possible; 1 is perfect",
        ));
    }
    rows.extend([
        Row::new(
            "Blocked moves per 100 steps",
            decimal(test.blocked_per_100_steps, 2),
            "failures included",
        ),
        Row::new(
            "Free of collisions",
            percent(test.collision_free_rate),
            "episodes without a single blocked move",
        ),
    ]);
    rows
}
