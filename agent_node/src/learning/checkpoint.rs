//! A training laid down in one file, to be taken up again as if nothing had happened.
//!
//! `checkpoint.safetensors` holds the weights of both networks, Adam's moments, the replay memory
//! and, as JSON under its only metadata key, the progress and the state of every random sequence.

use std::{collections::HashMap, path::Path};

use candle_core::{DType, Device, Tensor};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    action::Action,
    image::Image,
    network::{QNetwork, WeightsError},
    replay_memory::{Experience, ReplayMemory},
    settings::Settings,
    training::{Plan, Progress, Training},
};

/// The form of the file; another one is refused.
const VERSION: u32 = 1;
const METADATA_KEY: &str = "training";

/// Why a file of tensors cannot be used.
#[derive(Debug, Error)]
pub enum LoadError {
    /// The file cannot be read.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is damaged or something else.
    #[error("{path} is damaged or no safetensors file: {reason}")]
    Damaged {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The file is of a training with other settings.
    #[error("{path} does not fit: {reason}")]
    DoesNotFit {
        /// The file.
        path: String,
        /// What does not fit.
        reason: String,
    },
}

#[derive(Serialize, Deserialize)]
struct State {
    version: u32,
    scenario: String,
    episodes: u32,
    seed: u64,
    progress: Progress,
    adam_step: u64,
    exploration_random: RandomState,
    replay_random: RandomState,
    /// The number of the first image in the file.
    first_image: u64,
}

#[derive(Serialize, Deserialize)]
struct RandomState {
    key: [u8; 32],
    stream: u64,
    /// In words of 32 bits; a u128 is no JSON number.
    position: String,
}

impl RandomState {
    fn of(random: &ChaCha8Rng) -> RandomState {
        let position = random.get_word_pos().to_string();
        RandomState { key: random.get_seed(), stream: random.get_stream(), position }
    }

    fn restore(&self) -> Result<ChaCha8Rng, String> {
        let mut random = ChaCha8Rng::from_seed(self.key);
        random.set_stream(self.stream);
        let position = self.position.parse();
        random.set_word_pos(position.map_err(|_| format!("random position '{}'", self.position))?);
        Ok(random)
    }
}

/// The bytes of `model.safetensors`: the weights of the training network, and nothing else.
pub fn model_bytes(network: &QNetwork) -> Result<Vec<u8>, candle_core::Error> {
    Ok(safetensors::serialize(network.tensors(), None)?)
}

/// A trained network from `model.safetensors`.
pub fn load_model(path: &Path, settings: &Settings) -> Result<QNetwork, LoadError> {
    let bytes = read(path)?;
    let (tensors, _) = parse(path, &bytes)?;
    let network = QNetwork::new(&settings.hidden_layers, &mut ChaCha8Rng::from_seed([0; 32]))
        .map_err(|error| does_not_fit(path, error))?;
    network.set_tensors("", &tensors).map_err(|error| does_not_fit(path, error))?;
    Ok(network)
}

impl Training {
    /// The bytes of `checkpoint.safetensors`.
    pub fn checkpoint_bytes(&self) -> Result<Vec<u8>, candle_core::Error> {
        let learner = &self.learner;
        let memory = &learner.memory;
        let needed = memory.needed_images();
        let state = State {
            version: VERSION,
            scenario: self.plan.scenario.clone(),
            episodes: self.plan.episodes,
            seed: self.plan.seed,
            progress: self.progress.clone(),
            adam_step: learner.adam.step,
            exploration_random: RandomState::of(&learner.exploration_random),
            replay_random: RandomState::of(&learner.replay_random),
            first_image: needed.start,
        };
        let device = &Device::Cpu;
        let mut tensors: Vec<(String, Tensor)> = Vec::new();
        for (prefix, network) in [("train.", &learner.train), ("target.", &learner.target)] {
            let named = network.tensors();
            tensors.extend(named.map(|(name, tensor)| (format!("{prefix}{name}"), tensor.clone())));
        }
        for ((name, _), moments) in learner.train.tensors().zip(&learner.adam.moments) {
            tensors.push((format!("adam.{name}"), moments.clone()));
        }
        let images: Vec<u8> =
            needed.clone().flat_map(|n| memory.image(n).iter().copied()).collect();
        let count = (needed.end - needed.start) as usize;
        tensors.push((
            "memory.images".into(),
            Tensor::from_vec(images, (count, Image::HEIGHT, Image::WIDTH, 3), device)?,
        ));
        let mut column = |name: &str, value: &dyn Fn(Experience) -> u32| {
            let values: Vec<u32> = memory.oldest_first().map(value).collect();
            let count = values.len();
            tensors.push((format!("memory.{name}"), Tensor::from_vec(values, count, device)?));
            Ok::<(), candle_core::Error>(())
        };
        // Images are counted from the first one in the file. Rewards go as bits, to stay exact.
        column("state", &|e| (e.state - needed.start) as u32)?;
        column("next_state", &|e| (e.next_state - needed.start) as u32)?;
        column("action", &|e| u32::from(e.action.index()))?;
        column("reward_bits", &|e| e.reward.to_bits())?;
        column("terminated", &|e| u32::from(e.terminated))?;

        let state = serde_json::to_string(&state).map_err(candle_core::Error::wrap)?;
        let metadata = HashMap::from([(METADATA_KEY.to_owned(), state)]);
        Ok(safetensors::serialize(tensors, Some(metadata))?)
    }

    /// Takes a training up again where [`Training::checkpoint_bytes`] laid it down. The plan and
    /// the settings must be those of then.
    pub fn load(path: &Path, plan: Plan, settings: Settings) -> Result<Training, LoadError> {
        let bytes = read(path)?;
        let (tensors, metadata) = parse(path, &bytes)?;
        let damaged =
            |reason: String| LoadError::Damaged { path: path.display().to_string(), reason };
        let state =
            metadata.get(METADATA_KEY).ok_or_else(|| damaged("it is no checkpoint".into()))?;
        let state: State =
            serde_json::from_str(state).map_err(|error| damaged(error.to_string()))?;
        if state.version != VERSION {
            let reason = format!("it has version {}, expected {VERSION}", state.version);
            return Err(does_not_fit(path, reason));
        }
        let saved = Plan { scenario: state.scenario, episodes: state.episodes, seed: state.seed };
        if saved != plan {
            let reason = format!("it is of {saved:?}, not of {plan:?}");
            return Err(does_not_fit(path, reason));
        }
        let mut training =
            Training::new(plan, settings).map_err(|error| does_not_fit(path, error))?;
        let learner = &mut training.learner;
        let fits =
            |result: Result<(), WeightsError>| result.map_err(|error| does_not_fit(path, error));
        fits(learner.train.set_tensors("train.", &tensors))?;
        fits(learner.target.set_tensors("target.", &tensors))?;
        let names: Vec<String> = learner.train.tensors().map(|(name, _)| name.to_owned()).collect();
        for (name, moments) in names.iter().zip(&mut learner.adam.moments) {
            let saved = tensors.get(&format!("adam.{name}"));
            let saved =
                saved.filter(|saved| saved.dims() == moments.dims() && saved.dtype() == DType::F32);
            *moments = saved.ok_or_else(|| damaged(format!("adam.{name} is missing")))?.clone();
        }
        learner.adam.step = state.adam_step;
        learner.memory = memory(&tensors, learner.settings.memory_capacity, state.first_image)
            .map_err(damaged)?;
        learner.exploration_random = state.exploration_random.restore().map_err(damaged)?;
        learner.replay_random = state.replay_random.restore().map_err(damaged)?;
        training.progress = state.progress;
        Ok(training)
    }
}

fn memory(
    tensors: &HashMap<String, Tensor>,
    capacity: usize,
    first_image: u64,
) -> Result<ReplayMemory, String> {
    let tensor = |name: &str| {
        let name = format!("memory.{name}");
        tensors.get(&name).ok_or(format!("{name} is missing"))
    };
    let column = |name: &str| {
        tensor(name)?.to_vec1::<u32>().map_err(|error| format!("memory.{name}: {error}"))
    };
    let images = tensor("images")?.flatten_all().and_then(|images| images.to_vec1::<u8>());
    let images = images.map_err(|error| format!("memory.images: {error}"))?;
    let count = images.len() / Image::BYTES;
    let [states, next_states, actions, rewards, terminated] =
        ["state", "next_state", "action", "reward_bits", "terminated"].map(column);
    let (states, next_states, actions, rewards, terminated) =
        (states?, next_states?, actions?, rewards?, terminated?);
    let length = states.len();
    let columns = [&next_states, &actions, &rewards, &terminated];
    if length > capacity || columns.iter().any(|column| column.len() != length) {
        return Err(format!("a memory of {length} experiences, or of unequal columns"));
    }
    let mut experiences = Vec::with_capacity(length);
    for index in 0..length {
        let reward = f32::from_bits(rewards[index]);
        let action = u8::try_from(actions[index]).ok().and_then(|a| Action::try_from(a).ok());
        let (Some(action), true) = (action, reward.is_finite()) else {
            return Err(format!("experience {index} has a wrong action or reward"));
        };
        if states[index] as usize >= count || next_states[index] as usize >= count {
            return Err(format!("experience {index} points at an image that is not there"));
        }
        experiences.push(Experience {
            state: first_image + u64::from(states[index]),
            next_state: first_image + u64::from(next_states[index]),
            action,
            reward,
            terminated: terminated[index] != 0,
        });
    }
    if count > 2 * capacity + 2 || images.len() != count * Image::BYTES {
        return Err(format!("memory.images has {} bytes", images.len()));
    }
    Ok(ReplayMemory::restore(capacity, experiences, first_image, &images))
}

fn read(path: &Path) -> Result<Vec<u8>, LoadError> {
    std::fs::read(path)
        .map_err(|source| LoadError::Read { path: path.display().to_string(), source })
}

type Parsed = (HashMap<String, Tensor>, HashMap<String, String>);

fn parse(path: &Path, bytes: &[u8]) -> Result<Parsed, LoadError> {
    let damaged = |reason: String| LoadError::Damaged { path: path.display().to_string(), reason };
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| damaged(e.to_string()))?;
    let metadata = header.metadata().clone().unwrap_or_default();
    let tensors = candle_core::safetensors::load_buffer(bytes, &Device::Cpu);
    Ok((tensors.map_err(|error| damaged(error.to_string()))?, metadata))
}

fn does_not_fit(path: &Path, reason: impl ToString) -> LoadError {
    LoadError::DoesNotFit { path: path.display().to_string(), reason: reason.to_string() }
}
