//! The part of a checkpoint that is stored as JSON: everything except its tensors.

use std::{borrow::Cow, collections::BTreeMap, time::Duration};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use task::Random;

use crate::{
    settings::Settings,
    training::{CurrentEpisode, Progress},
};

/// The file format version; files with other versions are rejected.
pub(super) const VERSION: u32 = 8;

/// The plan, the settings, the progress and the positions in the random sequences.
#[derive(Serialize, Deserialize)]
pub(super) struct State<'a> {
    pub(super) version: u32,
    pub(super) scenario: String,
    pub(super) episodes: u32,
    pub(super) seed: u64,
    pub(super) rooms: usize,
    pub(super) settings: Cow<'a, Settings>,
    /// The progress, without its records.
    pub(super) progress: Cow<'a, Progress>,
    pub(super) adam_step: u64,
    pub(super) exploration_position: String,
    pub(super) replay_position: String,
    /// The number of the first image in the file.
    pub(super) first_image: u64,
    /// The index of the oldest transition, which is the first in the file.
    pub(super) oldest: usize,
}

/// Returns the current position in a random sequence, as a string because a `u128` does not fit in
/// a JSON number. The key of the sequence is not saved: it follows from the seed of the run.
pub(super) fn position(random: &Random) -> String {
    random.position().to_string()
}

/// Moves a random sequence to a saved position.
pub(super) fn set_position(random: &mut Random, position: &str) -> Result<(), String> {
    let parsed = position.parse::<u128>();
    random.set_position(parsed.map_err(|_| format!("invalid sequence position '{position}'"))?);
    Ok(())
}

impl State<'_> {
    /// Checks that the state is consistent with itself and with the number of records.
    pub(super) fn check(&self, records: usize) -> Result<(), String> {
        let progress = &self.progress;
        // No training run lasts longer than a hundred years, or stores more images and performs
        // more steps and updates than are possible in that time.
        const MAX_TIME: Duration = Duration::from_secs(100 * 365 * 86_400);
        const MAX_COUNT: u64 = 1 << 48;
        let active: Vec<&CurrentEpisode> = progress.current.iter().flatten().collect();
        let problem = if records + active.len() != progress.next_episode as usize
            || progress.next_episode > self.episodes
        {
            "the number of started episodes is inconsistent with the rest of the checkpoint"
        } else if progress.current.len() != self.rooms {
            "the number of current episodes differs from the number of simulators"
        } else if active.iter().any(|current| current.episode >= progress.next_episode) {
            "a current episode has not started"
        } else if progress.begun.as_ref().is_some_and(|begun| {
            begun.actions.len() != active.len()
                || active.iter().any(|current| current.image.is_none())
        }) {
            "the unfinished step does not match the current episodes"
        } else if progress.wall > MAX_TIME || progress.update_time > MAX_TIME {
            "its wall time is out of range (expected: at most 100 years)"
        } else if [self.first_image, progress.total_steps, progress.updates]
            .into_iter()
            .any(|count| count > MAX_COUNT)
        {
            "its number of images, steps or updates is out of range"
        } else if self.adam_step != progress.updates {
            "Adam's number of updates differs from that of the training run"
        } else {
            return Ok(());
        };
        Err(problem.to_owned())
    }
}

/// Returns a description of the hyperparameters that differ.
pub(super) fn difference(saved: &Settings, given: &Settings) -> String {
    let given = fields(given);
    let differing = fields(saved).into_iter().filter_map(|(name, value)| {
        let other = given.get(&name)?;
        (*other != value).then(|| format!("its {name} is {value} (expected: {other})"))
    });
    differing.collect::<Vec<_>>().join("; ")
}

/// Returns the hyperparameters, keyed by their JSON names, such as `replay.batch_size`.
fn fields(settings: &Settings) -> BTreeMap<String, Value> {
    let mut all = BTreeMap::new();
    if let Ok(Value::Object(groups)) = serde_json::to_value(settings) {
        for (group, fields) in groups {
            let Value::Object(fields) = fields else { continue };
            all.extend(fields.into_iter().map(|(name, value)| (format!("{group}.{name}"), value)));
        }
    }
    all
}
