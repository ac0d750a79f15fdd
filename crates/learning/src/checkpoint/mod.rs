//! A training laid down in one file, to be taken up again as if nothing had happened.
//!
//! `checkpoint.safetensors` holds the weights of both networks, Adam's moments in the same shapes, the
//! replay memory, the records of the episodes and, under its only metadata key, a checksum of the whole
//! and, as JSON, the rest of the progress and the position in every random sequence.

mod column;
mod file;
mod load_error;
mod memory;
mod model;
mod state;

use std::{borrow::Cow, collections::HashMap, fmt::Display, path::Path};

use candle_core::{Device, Tensor};

use self::{
    column::{Column, PIECE, checksum, images_name, records_name},
    file::{File, METADATA_KEY, read},
    load_error::does_not_fit,
    memory::memory,
    model::network,
    state::{State, VERSION, difference, position, set_position},
};
pub use self::{
    load_error::LoadError,
    model::{load_model, model_bytes},
};
use super::{
    replay_memory::{Experience, Frame},
    settings::Settings,
    training::{Plan, Progress, Training},
};

impl Training {
    /// Writes `checkpoint.safetensors`, image by image, without holding all of it in memory.
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
            adam_step: learner.adam.step,
            exploration_position: position(&learner.exploration_random),
            replay_position: position(&learner.replay_random),
            first_image: needed.start,
            oldest: memory.oldest_index(),
        };
        let device = &Device::Cpu;
        let mut tensors: Vec<(String, Column)> = Vec::new();
        for (prefix, parameters) in learner.parameters() {
            let network = parameters.network()?;
            let named = network.tensors();
            tensors.extend(
                named.map(|(name, tensor)| {
                    (prefix.to_owned() + &name, Column::Tensor(tensor.clone()))
                }),
            );
        }
        let frames = || needed.clone().map(|number| memory.frame(number));
        for (piece, first) in needed.clone().step_by(PIECE as usize).enumerate() {
            let numbers = first..needed.end.min(first + PIECE);
            tensors.push((images_name(piece), Column::images(memory, numbers)));
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
        let mut column = |name: &str, value: &dyn Fn(Experience) -> u32| {
            add(name, memory.oldest_first().map(value).collect())
        };
        // Images are counted from the first one in the file. Rewards go as bits, to stay exact.
        column("state", &|e| (e.state - needed.start) as u32)?;
        column("next_state", &|e| (e.next_state - needed.start) as u32)?;
        column("action", &|e| u32::from(e.action.index()))?;
        column("reward_bits", &|e| e.reward.to_bits())?;
        column("terminated", &|e| u32::from(e.terminated))?;
        for (piece, records) in self.progress.records.pieces().enumerate() {
            tensors.push((records_name(piece), Column::records(records)));
        }

        tensors.sort_by(|(a, _), (b, _)| a.cmp(b));
        let state = serde_json::to_string(&state).map_err(candle_core::Error::wrap)?;
        let views = tensors.iter().map(|(name, column)| (name.as_str(), column));
        let sealed = format!("{:08x} {state}", checksum(&state, views));
        let metadata = HashMap::from([(METADATA_KEY.to_owned(), sealed)]);
        Ok(safetensors::serialize_to_file(tensors, Some(metadata), path)?)
    }

    /// Takes a training up again where [`Training::write_checkpoint`] laid it down. The plan and
    /// the settings must be those of then.
    pub fn load(path: &Path, plan: Plan, settings: Settings) -> Result<Training, LoadError> {
        let bytes = read(path)?;
        let file = File::parse(path, &bytes)?;
        let damaged = |reason: String| file.damaged(reason);
        let state = file.state()?;
        if state.version != VERSION {
            let reason = format!("it has version {}, expected {VERSION}", state.version);
            return Err(does_not_fit(path, reason));
        }
        let differs = |name: &str, saved: &dyn Display, given: &dyn Display| {
            let reason = format!("its {name} is {saved}, not {given}");
            Err(does_not_fit(path, reason))
        };
        if state.scenario != plan.scenario {
            return differs("scenario", &state.scenario, &plan.scenario);
        } else if state.episodes != plan.episodes {
            return differs("episodes", &state.episodes, &plan.episodes);
        } else if state.seed != plan.seed {
            return differs("seed", &state.seed, &plan.seed);
        } else if state.rooms != plan.rooms {
            return differs("number of simulators", &state.rooms, &plan.rooms);
        } else if *state.settings != settings {
            return Err(does_not_fit(path, difference(&state.settings, &settings)));
        }
        let records = file.records().map_err(damaged)?;
        state.check(records.len()).map_err(damaged)?;
        let mut training =
            Training::new(plan, settings).map_err(|error| does_not_fit(path, error))?;
        let learner = &mut training.learner;
        let tensors = file.tensors().map_err(|error| file.damaged(error))?;
        for (prefix, parameters) in learner.parameters_mut() {
            let saved = network(prefix, &state.settings, &tensors);
            let saved = saved.map_err(|error| does_not_fit(path, error))?;
            parameters.read(&saved).map_err(|error| does_not_fit(path, error))?;
        }
        learner.adam.step = state.adam_step;
        learner.memory =
            memory(&file, &learner.memory, state.first_image, state.oldest).map_err(damaged)?;
        let images = learner.memory.needed_images();
        let mut seen = state.progress.current.iter().flatten().filter_map(|current| current.image);
        if !seen.all(|image| images.contains(&image)) {
            return Err(damaged("what is seen in a room is not in the memory".into()));
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
