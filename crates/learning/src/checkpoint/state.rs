//! What a checkpoint holds besides its tensors, as JSON.

use std::{borrow::Cow, collections::BTreeMap, time::Duration};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use task::Random;

use crate::{
    settings::Settings,
    training::{CurrentEpisode, Progress},
};

/// The form of the file; another one is refused.
pub(super) const VERSION: u32 = 7;

#[derive(Serialize, Deserialize)]
pub(super) struct State<'a> {
    pub(super) version: u32,
    pub(super) scenario: String,
    pub(super) episodes: u32,
    pub(super) seed: u64,
    pub(super) rooms: usize,
    pub(super) settings: Cow<'a, Settings>,
    /// Without its records.
    pub(super) progress: Cow<'a, Progress>,
    pub(super) adam_step: u64,
    pub(super) exploration_position: String,
    pub(super) replay_position: String,
    /// The number of the first image in the file.
    pub(super) first_image: u64,
    /// The index of the oldest experience, which is the first in the file.
    pub(super) oldest: usize,
}

/// Where a random sequence is, whose key follows from the run's seed. A u128 is no JSON number.
pub(super) fn position(random: &Random) -> String {
    random.position().to_string()
}

pub(super) fn set_position(random: &mut Random, position: &str) -> Result<(), String> {
    random.set_position(position.parse().map_err(|_| format!("random position '{position}'"))?);
    Ok(())
}

impl State<'_> {
    /// Checks that the numbers are consistent with each other and with the number of records.
    pub(super) fn check(&self, records: usize) -> Result<(), String> {
        let progress = &self.progress;
        // A hundred years, and more images and updates than they could bring.
        const LONGEST: Duration = Duration::from_secs(100 * 365 * 86_400);
        const MOST: u64 = 1 << 48;
        let active: Vec<&CurrentEpisode> = progress.current.iter().flatten().collect();
        let problem = if records + active.len() != progress.next_episode as usize
            || progress.next_episode > self.episodes
        {
            "it has more or fewer episodes than were begun"
        } else if progress.current.len() != self.rooms {
            "it has another number of rooms than it says"
        } else if active.iter().any(|current| current.episode >= progress.next_episode) {
            "a room is in an episode that was not begun"
        } else if progress.begun.as_ref().is_some_and(|begun| {
            begun.actions.len() != active.len()
                || active.iter().any(|current| current.image.is_none())
        }) {
            "a step was begun in another number of rooms"
        } else if progress.wall > LONGEST || progress.update_time > LONGEST {
            "it took more than a hundred years"
        } else if self.first_image > MOST || progress.total_steps > MOST || progress.updates > MOST
        {
            "its number of steps is out of range"
        } else if self.adam_step != progress.updates {
            "Adam counts other updates than the training"
        } else {
            return Ok(());
        };
        Err(problem.to_owned())
    }
}

/// Which hyperparameters differ, for people.
pub(super) fn difference(saved: &Settings, given: &Settings) -> String {
    let given = fields(given);
    let differing = fields(saved).into_iter().filter_map(|(name, value)| {
        let other = given.get(&name)?;
        (*other != value).then(|| format!("its {name} is {value}, not {other}"))
    });
    differing.collect::<Vec<_>>().join("; ")
}

/// The hyperparameters by their names, such as `replay.batch_size`, through JSON, which knows them.
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
