//! Checkpoints: a training run is saved to one file and can be resumed with the same result as an
//! uninterrupted run.
//!
//! `checkpoint.safetensors` contains the weights of both networks, Adam's moments in the same
//! shapes, the replay memory and the episode records. Its only metadata key holds a checksum and,
//! as JSON, the plan, the settings, the rest of the progress and the positions in the random
//! sequences. The checksum covers the tensors and the JSON.
//!
//! # Examples
//!
//! ```
//! use learning::{
//!     settings::Preset,
//!     training::{Plan, Training},
//! };
//!
//! let plan = Plan { scenario: "empty".into(), episodes: 10, seed: 1, rooms: 1 };
//! let settings = Preset::Paper.settings();
//! let training = Training::new(plan.clone(), settings.clone())?;
//! let directory = tempfile::tempdir()?;
//! let path = directory.path().join("checkpoint.safetensors");
//! training.write_checkpoint(&path)?;
//!
//! let resumed = Training::load(&path, plan.clone(), settings.clone())?;
//! assert_eq!(resumed.progress, training.progress);
//!
//! let other = Plan { seed: 2, ..plan };
//! let error = Training::load(&path, other, settings).unwrap_err();
//! assert!(error.to_string().ends_with("does not match this run: its seed is 1 (expected: 2)"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod column;
mod file;
mod load_error;
mod memory;
mod model;
mod state;

use std::{borrow::Cow, collections::HashMap, fmt::Display, path::Path};

use candle_core::{Device, Tensor};

use self::{
    column::{CHUNK, Column, checksum, images_name, records_name},
    file::{File, METADATA_KEY, read},
    load_error::mismatch,
    memory::{memory, read_priorities},
    state::{State, VERSION, difference, position, set_position},
};
pub use self::{
    load_error::LoadError,
    model::{load_model, model_bytes},
};
use super::{
    replay_memory::{Frame, Transition},
    settings::Settings,
    training::{Plan, Progress, Training},
};

impl Training {
    /// Writes the training run to a checkpoint file. Images and records are converted one chunk at
    /// a time, so the whole file is never in memory.
    ///
    /// # Errors
    ///
    /// Returns an error if a tensor cannot be converted or the file cannot be written.
    pub fn write_checkpoint(&self, path: &Path) -> Result<(), candle_core::Error> {
        let learner = &self.learner;
        let memory = &learner.memory;
        let needed = memory.needed_images();
        let state = State {
            version: VERSION,
            scenario: self.plan.scenario.clone(),
            episodes: self.plan.episodes,
            seed: self.plan.seed,
            rooms: self.plan.rooms,
            settings: Cow::Borrowed(&learner.settings),
            progress: Cow::Borrowed(&self.progress),
            adam_step: learner.backend.updates(),
            exploration_position: position(&learner.exploration_random),
            replay_position: position(&learner.replay_random),
            first_image: needed.start,
            oldest: memory.oldest_index(),
        };
        let device = &Device::Cpu;
        let mut tensors: Vec<(String, Column)> = Vec::new();
        for (prefix, network) in learner.backend.networks() {
            let named = network.tensors()?.into_iter();
            tensors.extend(
                named.map(|(name, tensor)| (prefix.to_owned() + &name, Column::Tensor(tensor))),
            );
        }
        let frames = || needed.clone().map(|number| memory.frame(number));
        for (chunk, first) in needed.clone().step_by(CHUNK as usize).enumerate() {
            let numbers = first..needed.end.min(first + CHUNK);
            tensors.push((images_name(chunk), Column::images(memory, numbers)));
        }
        let mut add = |name: &str, values: Vec<u32>| {
            let count = values.len();
            let tensor = Tensor::from_vec(values, count, device)?;
            tensors.push((format!("memory.{name}"), Column::Tensor(tensor)));
            Ok::<(), candle_core::Error>(())
        };
        let mut image_column =
            |name: &str, value: &dyn Fn(&Frame) -> u32| add(name, frames().map(value).collect());
        image_column("images.back", &|f| f.before.map_or(0, |(back, _)| back.into()))?;
        image_column("images.action", &|f| f.before.map_or(0, |(_, a)| a.index().into()))?;
        image_column("images.tried", &|f| f.tried.bits().into())?;
        let mut column = |name: &str, value: &dyn Fn(Transition) -> u32| {
            add(name, memory.oldest_first().map(value).collect())
        };
        // Image numbers are relative to the first image in the file.
        column("state", &|t| (t.state - needed.start) as u32)?;
        column("next_state", &|t| (t.next_state - needed.start) as u32)?;
        column("action", &|t| u32::from(t.action.index()))?;
        column("reward_bits", &|t| t.reward.to_bits())?;
        column("terminated", &|t| u32::from(t.terminated))?;
        if let Some(priorities) = &learner.priorities {
            let bits = (0..memory.len()).map(|index| priorities.get(index).to_bits());
            add("priority_bits", bits.collect())?;
        }
        for (chunk, records) in self.progress.records.chunks().enumerate() {
            tensors.push((records_name(chunk), Column::records(records)));
        }

        tensors.sort_by(|(a, _), (b, _)| a.cmp(b));
        let state = serde_json::to_string(&state).map_err(candle_core::Error::wrap)?;
        let views = tensors.iter().map(|(name, column)| (name.as_str(), column));
        let metadata = format!("{:08x} {state}", checksum(&state, views));
        let metadata = HashMap::from([(METADATA_KEY.to_owned(), metadata)]);
        Ok(safetensors::serialize_to_file(tensors, Some(metadata), path)?)
    }

    /// Loads a training run that [`write_checkpoint`](Training::write_checkpoint) saved.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be read, is damaged, has a different format version, or
    /// was saved with a different plan or different settings.
    pub fn load(path: &Path, plan: Plan, settings: Settings) -> Result<Training, LoadError> {
        let bytes = read(path)?;
        let file = File::parse(path, &bytes)?;
        let damaged = |reason: String| file.damaged(reason);
        let state = file.state()?;
        if state.version != VERSION {
            let reason = format!("its version is {} (expected: {VERSION})", state.version);
            return Err(mismatch(path, reason));
        }
        let differs = |name: &str, saved: &dyn Display, given: &dyn Display| {
            let reason = format!("its {name} is {saved} (expected: {given})");
            Err(mismatch(path, reason))
        };
        if state.scenario != plan.scenario {
            return differs("scenario", &state.scenario, &plan.scenario);
        } else if state.episodes != plan.episodes {
            return differs("number of episodes", &state.episodes, &plan.episodes);
        } else if state.seed != plan.seed {
            return differs("seed", &state.seed, &plan.seed);
        } else if state.rooms != plan.rooms {
            return differs("number of simulators", &state.rooms, &plan.rooms);
        } else if *state.settings != settings {
            return Err(mismatch(path, difference(&state.settings, &settings)));
        }
        let records = file.records().map_err(damaged)?;
        state.check(records.len()).map_err(damaged)?;
        let mut training = Training::new(plan, settings).map_err(|error| mismatch(path, error))?;
        let learner = &mut training.learner;
        let tensors = file.tensors().map_err(|error| file.damaged(error))?;
        for (prefix, network) in learner.backend.networks_mut() {
            network.read(prefix, &tensors).map_err(|error| mismatch(path, error))?;
        }
        learner.backend.set_updates(state.adam_step);
        learner.memory =
            memory(&file, &learner.memory, state.first_image, state.oldest).map_err(damaged)?;
        if let Some(priorities) = &mut learner.priorities {
            read_priorities(&file, learner.memory.len(), priorities).map_err(damaged)?;
        }
        let images = learner.memory.needed_images();
        let current = state.progress.current.iter().flatten();
        if !current.filter_map(|episode| episode.image).all(|image| images.contains(&image)) {
            return Err(damaged("an episode's current image is not in the replay memory".into()));
        }
        set_position(&mut learner.exploration_random, &state.exploration_position)
            .map_err(damaged)?;
        set_position(&mut learner.replay_random, &state.replay_position).map_err(damaged)?;
        training.progress = Progress { records, ..state.progress.into_owned() };
        Ok(training)
    }
}

#[cfg(test)]
mod tests;
