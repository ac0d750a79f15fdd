//! What a training leaves behind: one record per episode.

use std::sync::Arc;

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
            episode_return: Some(episode_return as f32).filter(|sum| sum.is_finite())?,
            epsilon: (0.0..=1.0).contains(&epsilon).then_some(epsilon)?,
            loss: (!loss.is_nan()).then_some(loss),
            blocked: whole(blocked)?,
            terminated: whole(terminated)? != 0,
        })
    }
}

/// The records of a training, in the order in which its episodes ended.
///
/// A clone shares all but the latest of them, so it costs next to nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    /// [`CHUNK`] records each.
    full: Vec<Arc<[EpisodeRecord]>>,
    latest: Vec<EpisodeRecord>,
}

/// Records that are shared as one.
const CHUNK: usize = 1024;

impl Records {
    /// Adds the record of the episode that has just ended.
    pub fn push(&mut self, record: EpisodeRecord) {
        self.latest.push(record);
        if self.latest.len() == CHUNK {
            self.full.push(self.latest.as_slice().into());
            self.latest.clear();
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        CHUNK * self.full.len() + self.latest.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All of them, in their order.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &EpisodeRecord> {
        self.pieces().flatten()
    }

    /// The last so many, or all if there are fewer, in their order.
    pub fn recent(&self, count: usize) -> impl Iterator<Item = &EpisodeRecord> {
        self.iter().skip(self.len().saturating_sub(count))
    }

    /// All of them, at most [`CHUNK`] at once; the last piece may be empty.
    pub(super) fn pieces(&self) -> impl DoubleEndedIterator<Item = &[EpisodeRecord]> {
        let full = self.full.iter().map(AsRef::as_ref);
        full.chain([self.latest.as_slice()])
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
            for (column, wrong) in
                [(0, -1.0), (1, 0.5), (2, f64::NAN), (2, 1e300), (3, 2.0), (3, f64::NAN), (5, 1e10)]
            {
                let mut row = record.to_row();
                row[column] = wrong;
                assert_eq!(EpisodeRecord::from_row(&row), None);
            }
        }
    }

    #[test]
    fn records_are_what_was_pushed_and_a_copy_stays_as_it_was() {
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
        let mut copies = Vec::new();
        for episode in 0..3 * full {
            if (episode + 1) % full <= 2 {
                copies.push((episode, records.clone()));
            }
            assert_eq!(records.len(), episode as usize);
            records.push(record(episode));
            let recent: Vec<u32> = records.recent(3).map(|record| record.episode).collect();
            assert!(recent.into_iter().eq(episode.saturating_sub(2)..=episode));
        }
        assert_eq!(copies.len(), 9);
        for (count, copy) in copies {
            assert!(numbers(&copy).into_iter().eq(0..count));
            assert!(copy.pieces().all(|piece| piece.len() <= CHUNK));
        }
        assert!(numbers(&records).into_iter().eq(0..3 * full));
    }
}
