//! The records of training episodes.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// The result of a training episode, which is a row of `episodes.csv`. The column names are part of
/// the public interface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRecord {
    /// Index of the episode, starting at 0: `e` in eq. 4.
    pub episode: u32,
    /// Number of steps, including blocked ones.
    pub steps: u32,
    /// Undiscounted sum of the rewards.
    #[serde(rename = "return")]
    pub episode_return: f32,
    /// Exploration probability of the episode (eq. 4).
    pub epsilon: f64,
    /// Mean loss (eq. 5) of the updates during the episode; `None` if there were no updates.
    pub loss: Option<f64>,
    /// Number of steps blocked by a wall or an obstacle.
    pub blocked: u32,
    /// Whether the robot reached the exit; otherwise the episode was truncated.
    pub terminated: bool,
}

impl EpisodeRecord {
    /// Number of columns in a row returned by [`to_row`](EpisodeRecord::to_row).
    pub(super) const COLUMNS: usize = 7;

    /// Converts the record to numbers without rounding; a missing loss becomes NaN.
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

    /// Converts a row returned by [`to_row`](EpisodeRecord::to_row) back to a record. Returns
    /// `None` if a number is invalid.
    pub(super) fn from_row(row: &[f64; Self::COLUMNS]) -> Option<EpisodeRecord> {
        let [episode, steps, episode_return, epsilon, loss, blocked, terminated] = *row;
        let integer = |number: f64| {
            let is_valid = (0.0..=u32::MAX.into()).contains(&number) && number.fract() == 0.0;
            is_valid.then_some(number as u32)
        };
        Some(EpisodeRecord {
            episode: integer(episode)?,
            steps: integer(steps)?,
            episode_return: Some(episode_return as f32).filter(|sum| sum.is_finite())?,
            epsilon: (0.0..=1.0).contains(&epsilon).then_some(epsilon)?,
            loss: (!loss.is_nan()).then_some(loss),
            blocked: integer(blocked)?,
            terminated: integer(terminated)? != 0,
        })
    }
}

/// The records of a training run, in the order in which its episodes ended.
///
/// Clones share all but the latest records, which makes cloning cheap.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    /// Chunks of [`CHUNK`] records.
    full: Vec<Arc<[EpisodeRecord]>>,
    latest: Vec<EpisodeRecord>,
}

/// Number of records in a shared chunk.
const CHUNK: usize = 1024;

impl Records {
    /// Appends a record.
    pub fn push(&mut self, record: EpisodeRecord) {
        self.latest.push(record);
        if self.latest.len() == CHUNK {
            self.full.push(self.latest.as_slice().into());
            self.latest.clear();
        }
    }

    /// Returns the number of records.
    pub fn len(&self) -> usize {
        CHUNK * self.full.len() + self.latest.len()
    }

    /// Returns whether there are no records.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Iterates over the records.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &EpisodeRecord> {
        self.chunks().flatten()
    }

    /// Iterates over the last `count` records, or over all records if there are fewer.
    pub fn recent(&self, count: usize) -> impl Iterator<Item = &EpisodeRecord> {
        self.iter().skip(self.len().saturating_sub(count))
    }

    /// Iterates over slices of at most [`CHUNK`] records; the last slice may be empty.
    pub(super) fn chunks(&self) -> impl DoubleEndedIterator<Item = &[EpisodeRecord]> {
        let full = self.full.iter().map(AsRef::as_ref);
        full.chain([self.latest.as_slice()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_survives_the_conversion_to_numbers() {
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
            for (column, invalid) in
                [(0, -1.0), (1, 0.5), (2, f64::NAN), (2, 1e300), (3, 2.0), (3, f64::NAN), (5, 1e10)]
            {
                let mut row = record.to_row();
                row[column] = invalid;
                assert_eq!(EpisodeRecord::from_row(&row), None);
            }
        }
    }

    #[test]
    fn records_keep_their_order_and_clones_do_not_change() {
        let record = |episode| EpisodeRecord {
            episode,
            steps: 1,
            episode_return: 0.0,
            epsilon: 0.1,
            loss: None,
            blocked: 0,
            terminated: true,
        };
        let numbers = |records: &Records| -> Vec<u32> {
            records.iter().map(|record| record.episode).collect()
        };
        let full = CHUNK as u32;
        let mut records = Records::default();
        let mut clones = Vec::new();
        for episode in 0..3 * full {
            if (episode + 1) % full <= 2 {
                clones.push((episode, records.clone()));
            }
            assert_eq!(records.len(), episode as usize);
            records.push(record(episode));
            let recent: Vec<u32> = records.recent(3).map(|record| record.episode).collect();
            assert!(recent.into_iter().eq(episode.saturating_sub(2)..=episode));
        }
        assert_eq!(clones.len(), 9);
        for (count, clone) in clones {
            assert!(numbers(&clone).into_iter().eq(0..count));
            assert!(clone.chunks().all(|chunk| chunk.len() <= CHUNK));
        }
        assert!(numbers(&records).into_iter().eq(0..3 * full));
    }
}
