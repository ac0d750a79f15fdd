//! Trainings side by side, as a table in Markdown.

use std::path::{Path, PathBuf};

use anyhow::Context;

use super::numbers::{count, decimal, duration, percent};
use crate::{learning::record::EpisodeRecord, run::Summary};

/// How many episodes the end of a training is.
const LAST: usize = 100;

/// A table with a row for each directory that a training has left.
///
/// # Errors
///
/// If `summary.json` or `episodes.csv` is missing or damaged in one of them.
pub fn runs_table(directories: &[PathBuf]) -> anyhow::Result<String> {
    let mut table = "\
| scenario | preset | seed | training steps | steps an episode, last 100 | training | \
test success | steps to the exit | fewest possible | free of collisions |
|---|---|---|---|---|---|---|---|---|---|
"
    .to_owned();
    for directory in directories {
        let context = || format!("no finished training in {}", directory.display());
        table += &row(directory).with_context(context)?;
    }
    Ok(table)
}

fn row(directory: &Path) -> anyhow::Result<String> {
    let summary: Summary =
        serde_json::from_str(&std::fs::read_to_string(directory.join("summary.json"))?)?;
    let records: Vec<EpisodeRecord> = csv::Reader::from_path(directory.join("episodes.csv"))?
        .deserialize()
        .collect::<Result<_, _>>()?;
    let last = &records[records.len().saturating_sub(LAST)..];
    let last_steps: u32 = last.iter().map(|record| record.steps).sum();
    let mut cells = vec![
        summary.scenario,
        summary.preset,
        summary.seed.to_string(),
        count(summary.steps),
        decimal(f64::from(last_steps) / last.len() as f64, 1),
        duration(summary.wall_s),
    ];
    let test = summary.evaluation;
    let number = |value: Option<f64>| decimal(value.unwrap_or(f64::NAN), 1);
    cells.extend(match test {
        Some(test) => [
            percent(test.success_rate),
            number(test.mean_steps),
            number(test.oracle_mean_steps),
            percent(test.collision_free_rate),
        ],
        None => ["–"; 4].map(str::to_owned),
    });
    Ok(format!("| {} |\n", cells.join(" | ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::RunDirectory;

    #[test]
    fn a_row_for_each_run_and_an_error_for_what_is_none() {
        let home = tempfile::tempdir().unwrap();
        let directory = RunDirectory::open(home.path()).unwrap();
        assert!(
            runs_table(&[home.path().to_owned()]).unwrap_err().to_string().contains("no finished")
        );
        let summary = Summary {
            scenario: "empty".into(),
            preset: "paper".into(),
            seed: 3,
            episodes: 2,
            steps: 51_316,
            wall_s: 1142.2,
            steps_per_s: 44.9,
            update_us: 700.0,
            evaluation: None,
        };
        directory.write_json("summary.json", &summary).unwrap();
        let record = EpisodeRecord {
            episode: 0,
            steps: 11,
            episode_return: -1.0,
            epsilon: 1.0,
            loss: None,
            blocked: 0,
            terminated: true,
        };
        let longer = EpisodeRecord { episode: 1, steps: 14, loss: Some(0.5), ..record.clone() };
        directory.write_episodes(&[record, longer]).unwrap();
        let table = runs_table(&[home.path().to_owned()]).unwrap();
        let row = table.lines().last().unwrap();
        assert_eq!(row, "| empty | paper | 3 | 51,316 | 12.5 | 19:02 | – | – | – | – |");
    }
}
