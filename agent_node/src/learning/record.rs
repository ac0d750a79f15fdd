//! What a training leaves behind: one record per episode.

use serde::{Deserialize, Serialize};

/// One row of `episodes.csv`. The column names are part of the command's contract.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRecord {
    /// Counts from 0, as `e` in eq. 4.
    pub episode: u32,
    /// Actions taken, blocked ones included.
    pub steps: u32,
    /// The undiscounted sum of the rewards.
    #[serde(rename = "return")]
    pub episode_return: f32,
    /// The exploration probability of this episode (eq. 4).
    pub epsilon: f64,
    /// Mean loss (eq. 5) of the episode's updates; empty where there was no update yet.
    pub loss: Option<f64>,
    /// How many of the steps were blocked by a wall or an obstacle.
    pub blocked: u32,
    /// Whether the robot reached the exit; if not, the episode was truncated.
    pub terminated: bool,
}

impl EpisodeRecord {
    /// How many numbers a record is.
    pub(super) const COLUMNS: usize = 7;

    /// The record as numbers, exactly. No loss is no number.
    pub(super) fn to_row(&self) -> [f64; Self::COLUMNS] {
        [
            self.episode.into(),
            self.steps.into(),
            self.episode_return.into(),
            self.epsilon,
            self.loss.unwrap_or(f64::NAN),
            self.blocked.into(),
            self.terminated.into(),
        ]
    }

    /// The record that [`EpisodeRecord::to_row`] made the numbers of, if there is one.
    pub(super) fn from_row(row: &[f64; Self::COLUMNS]) -> Option<EpisodeRecord> {
        let [episode, steps, episode_return, epsilon, loss, blocked, terminated] = *row;
        let whole = |number: f64| {
            let is_whole = (0.0..=u32::MAX.into()).contains(&number) && number.fract() == 0.0;
            is_whole.then_some(number as u32)
        };
        Some(EpisodeRecord {
            episode: whole(episode)?,
            steps: whole(steps)?,
            episode_return: episode_return as f32,
            epsilon: (0.0..=1.0).contains(&epsilon).then_some(epsilon)?,
            loss: (!loss.is_nan()).then_some(loss),
            blocked: whole(blocked)?,
            terminated: whole(terminated)? != 0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_the_same_after_it_was_numbers() {
        let record = EpisodeRecord {
            episode: u32::MAX,
            steps: 7,
            episode_return: -0.1,
            epsilon: 0.1 + 0.2,
            loss: Some(1.0 / 3.0),
            blocked: 3,
            terminated: true,
        };
        for record in [EpisodeRecord { loss: None, terminated: false, ..record.clone() }, record] {
            assert_eq!(EpisodeRecord::from_row(&record.to_row()).as_ref(), Some(&record));
            for (column, wrong) in [(0, -1.0), (1, 0.5), (3, 2.0), (3, f64::NAN), (5, 1e10)] {
                let mut row = record.to_row();
                row[column] = wrong;
                assert_eq!(EpisodeRecord::from_row(&row), None);
            }
        }
    }
}
