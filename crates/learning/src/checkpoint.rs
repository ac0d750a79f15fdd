//! A training laid down in one file, to be taken up again as if nothing had happened.
//!
//! `checkpoint.safetensors` holds the weights of both networks, Adam's moments in the same shapes, the
//! replay memory, the records of the episodes and, under its only metadata key, a checksum of the whole
//! and, as JSON, the rest of the progress and the position in every random sequence.

use std::{
    borrow::Cow, collections::HashMap, fmt::Display, ops::Range, path::Path, time::Duration,
};

use candle_core::{DType, Device, Tensor};
use crc::{CRC_32_ISCSI, Crc, Table};
use safetensors::{Dtype, SafeTensors, View, tensor::TensorView};
use serde::{Deserialize, Serialize};
use task::{Action, Image, Random};
use thiserror::Error;

use super::{
    greedy::ActionSet,
    network::{QNetwork, WeightsError},
    observation::input_size,
    perceptron::Perceptron,
    record::{EpisodeRecord, Records},
    replay_memory::{Experience, Frame, ReplayMemory},
    settings::Settings,
    training::{CurrentEpisode, Plan, Progress, Training},
};

/// The form of the file; another one is refused.
const VERSION: u32 = 7;
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
struct State<'a> {
    version: u32,
    scenario: String,
    episodes: u32,
    seed: u64,
    rooms: usize,
    settings: Cow<'a, Settings>,
    /// Without its records.
    progress: Cow<'a, Progress>,
    adam_step: u64,
    exploration_position: String,
    replay_position: String,
    /// The number of the first image in the file.
    first_image: u64,
    /// The index of the oldest experience, which is the first in the file.
    oldest: usize,
}

/// Where a random sequence is, whose key follows from the run's seed. A u128 is no JSON number.
fn position(random: &Random) -> String {
    random.position().to_string()
}

fn set_position(random: &mut Random, position: &str) -> Result<(), String> {
    random.set_position(position.parse().map_err(|_| format!("random position '{position}'"))?);
    Ok(())
}

/// The bytes of `model.safetensors`: the weights of a network, and nothing else.
pub fn model_bytes(network: &Perceptron) -> Result<Vec<u8>, candle_core::Error> {
    Ok(safetensors::serialize(network.network()?.tensors(), None)?)
}

/// A trained network from `model.safetensors`.
pub fn load_model(path: &Path, settings: &Settings) -> Result<QNetwork, LoadError> {
    let bytes = read(path)?;
    let file = File::parse(path, &bytes)?;
    let tensors = file.tensors().map_err(|error| file.damaged(error))?;
    network("", settings, &tensors).map_err(|error| does_not_fit(path, error))
}

fn network(
    prefix: &str,
    settings: &Settings,
    tensors: &HashMap<String, Tensor>,
) -> Result<QNetwork, WeightsError> {
    let inputs = input_size(settings.observation_frames);
    QNetwork::from_tensors(prefix, inputs, &settings.hidden_layers, tensors)
}

impl Training {
    /// Writes `checkpoint.safetensors`, image by image: nobody needs to hold all of it.
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

/// Images in a tensor of the file.
const PIECE: u64 = 256;

fn images_name(piece: usize) -> String {
    format!("memory.images.{piece:06}")
}

fn records_name(piece: usize) -> String {
    format!("records.{piece:06}")
}

/// A tensor of the file: as candle has it, or images or records, which are put together when they
/// are written.
enum Column<'a> {
    Tensor(Tensor),
    Images { memory: &'a ReplayMemory, numbers: Range<u64>, shape: [usize; 4] },
    Records { records: &'a [EpisodeRecord], shape: [usize; 2] },
}

impl<'a> Column<'a> {
    fn images(memory: &'a ReplayMemory, numbers: Range<u64>) -> Column<'a> {
        let count = (numbers.end - numbers.start) as usize;
        Column::Images { memory, numbers, shape: [count, Image::HEIGHT, Image::WIDTH, 3] }
    }

    fn records(records: &'a [EpisodeRecord]) -> Column<'a> {
        Column::Records { records, shape: [records.len(), EpisodeRecord::COLUMNS] }
    }
}

impl View for Column<'_> {
    fn dtype(&self) -> Dtype {
        match self {
            Column::Tensor(tensor) => View::dtype(tensor),
            Column::Images { .. } => Dtype::U8,
            Column::Records { .. } => Dtype::F64,
        }
    }

    fn shape(&self) -> &[usize] {
        match self {
            Column::Tensor(tensor) => View::shape(tensor),
            Column::Images { shape, .. } => shape,
            Column::Records { shape, .. } => shape,
        }
    }

    fn data(&self) -> Cow<'_, [u8]> {
        match self {
            Column::Tensor(tensor) => View::data(tensor),
            Column::Images { memory, numbers, .. } => {
                let images = numbers.clone().map(|number| memory.frame(number).image);
                images.collect::<Vec<_>>().into_flattened().into()
            }
            Column::Records { records, .. } => {
                let numbers = records.iter().flat_map(EpisodeRecord::to_row);
                numbers.flat_map(f64::to_le_bytes).collect()
            }
        }
    }

    fn data_len(&self) -> usize {
        match self {
            Column::Tensor(tensor) => View::data_len(tensor),
            Column::Images { shape, .. } => shape.iter().product(),
            Column::Records { shape, .. } => shape.iter().product::<usize>() * size_of::<f64>(),
        }
    }
}

impl State<'_> {
    /// Whether the numbers are such as a training may have that has so many records.
    fn check(&self, records: usize) -> Result<(), String> {
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
            "it has more steps than anybody can make"
        } else if self.adam_step != progress.updates {
            "Adam counts other updates than the training"
        } else {
            return Ok(());
        };
        Err(problem.to_owned())
    }
}

/// Which hyperparameters differ, for people.
fn difference(saved: &Settings, given: &Settings) -> String {
    // Through JSON, which knows the names of the fields.
    let fields = |settings: &Settings| match serde_json::to_value(settings) {
        Ok(serde_json::Value::Object(fields)) => fields,
        _ => serde_json::Map::new(),
    };
    let given = fields(given);
    let differing =
        fields(saved).into_iter().filter(|(name, value)| given.get(name) != Some(value));
    let parts: Vec<String> = differing
        .map(|(name, value)| {
            format!("its {name} is {value}, not {}", given.get(&name).unwrap_or(&value))
        })
        .collect();
    parts.join("; ")
}

fn memory(
    file: &File,
    empty: &ReplayMemory,
    first_image: u64,
    oldest: usize,
) -> Result<ReplayMemory, String> {
    let action = |index: u32| u8::try_from(index).ok().and_then(|a| Action::try_from(a).ok());
    let column = |name: &str| file.column(&format!("memory.{name}"));
    let mut images: Vec<&[u8; Image::BYTES]> = Vec::new();
    for piece in (0..).map(images_name).map_while(|name| file.tensors.tensor(&name).ok()) {
        let (whole, rest) = piece.data().as_chunks();
        if piece.dtype() != Dtype::U8 || !rest.is_empty() {
            return Err("a piece of memory.images holds something else than images".into());
        }
        images.extend(whole);
    }
    let count = images.len();
    let [backs, actions, tried] = ["images.back", "images.action", "images.tried"].map(column);
    let (backs, actions, tried) = (backs?, actions?, tried?);
    if [&backs, &actions, &tried].iter().any(|column| column.len() != count) {
        return Err("columns of images are unequal".into());
    }
    let mut frames = Vec::with_capacity(count);
    for (index, image) in images.iter().enumerate() {
        let back = u16::try_from(backs[index]).ok();
        let bits = u8::try_from(tried[index]).ok();
        let (Some(back), Some(action), Some(tried)) =
            (back, action(actions[index]), bits.and_then(ActionSet::from_bits))
        else {
            return Err(format!("image {index} has come about in a way that is not possible"));
        };
        let before = (back > 0).then_some((back, action));
        frames.push(Frame { image: **image, before, tried });
    }
    let [states, next_states, actions, rewards, terminated] =
        ["state", "next_state", "action", "reward_bits", "terminated"].map(column);
    let (states, next_states, actions, rewards, terminated) =
        (states?, next_states?, actions?, rewards?, terminated?);
    let length = states.len();
    let columns = [&next_states, &actions, &rewards, &terminated];
    if length > empty.capacity() || columns.iter().any(|column| column.len() != length) {
        return Err(format!("a memory of {length} experiences, or of unequal columns"));
    }
    let mut experiences = Vec::with_capacity(length);
    for index in 0..length {
        let reward = f32::from_bits(rewards[index]);
        let (Some(action), true) = (action(actions[index]), reward.is_finite()) else {
            return Err(format!("experience {index} has a wrong action or reward"));
        };
        let (state, next_state) = (states[index], next_states[index]);
        let in_order = index == 0 || next_state > next_states[index - 1];
        let is_near = next_state.saturating_sub(state) <= empty.most_between();
        if next_state as usize >= count || state >= next_state || !in_order || !is_near {
            return Err(format!("experience {index} points at an image that is not its own"));
        }
        experiences.push(Experience {
            state: first_image + u64::from(states[index]),
            next_state: first_image + u64::from(next_states[index]),
            action,
            reward,
            terminated: terminated[index] != 0,
        });
    }
    // Until the memory is full, the oldest experience is the first.
    if oldest != 0 && (length < empty.capacity() || oldest >= length) {
        return Err(format!("the oldest of {length} experiences cannot have the index {oldest}"));
    }
    Ok(empty.restore(experiences, oldest, first_image, frames.into_iter()))
}

fn read(path: &Path) -> Result<Vec<u8>, LoadError> {
    std::fs::read(path)
        .map_err(|source| LoadError::Read { path: path.display().to_string(), source })
}

/// A file of tensors, none of them copied yet.
struct File<'a> {
    path: &'a Path,
    tensors: SafeTensors<'a>,
    metadata: HashMap<String, String>,
}

impl<'a> File<'a> {
    fn parse(path: &'a Path, bytes: &'a [u8]) -> Result<File<'a>, LoadError> {
        let damaged = |error: safetensors::SafeTensorError| damaged(path, error);
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
        let metadata = header.metadata().clone().unwrap_or_default();
        Ok(File { path, tensors: SafeTensors::deserialize(bytes).map_err(damaged)?, metadata })
    }

    fn damaged(&self, reason: impl ToString) -> LoadError {
        damaged(self.path, reason)
    }

    /// The state of a training, if the file is as it was written.
    fn state(&self) -> Result<State<'static>, LoadError> {
        let sealed = self.metadata.get(METADATA_KEY);
        let sealed = sealed.ok_or_else(|| self.damaged("it is no checkpoint"))?;
        // Before version 4 there was no checksum before the state.
        if sealed.starts_with('{') {
            let reason = format!("it is of a version before {VERSION}");
            return Err(does_not_fit(self.path, reason));
        }
        let (written, state) =
            sealed.split_once(' ').ok_or_else(|| self.damaged("it has no checksum"))?;
        let state_is: State<'static> =
            serde_json::from_str(state).map_err(|error| self.damaged(error))?;
        let mut views: Vec<_> = self.tensors.iter().collect();
        views.sort_by_key(|(name, _)| *name);
        let found = checksum(state, views.iter().map(|(name, view)| (*name, view)));
        // Where random bytes are tried they shall get past it, to what is behind.
        if u32::from_str_radix(written, 16) != Ok(found) && !cfg!(fuzzing) {
            let reason = format!("its checksum is {found:08x}, not {written} as it says itself");
            return Err(self.damaged(reason));
        }
        Ok(state_is)
    }

    /// The tensors of floats: everything but the memory.
    fn tensors(&self) -> candle_core::Result<HashMap<String, Tensor>> {
        let floats = self.tensors.iter().filter(|(_, view)| view.dtype() == Dtype::F32);
        let tensor = |(name, view): (&str, TensorView)| {
            let (data, shape) = (view.data(), view.shape());
            let tensor = Tensor::from_raw_buffer(data, DType::F32, shape, &Device::Cpu)?;
            Ok((name.to_owned(), tensor))
        };
        floats.map(tensor).collect()
    }

    /// The records of the episodes.
    fn records(&self) -> Result<Records, String> {
        let mut records = Records::default();
        let pieces = (0..).map(records_name).map_while(|name| self.tensors.tensor(&name).ok());
        for piece in pieces {
            let (numbers, []) = piece.data().as_chunks() else {
                return Err("a piece of the records is damaged".into());
            };
            if piece.dtype() != Dtype::F64 {
                return Err("a piece of the records holds something else than 64-bit floats".into());
            }
            let numbers: Vec<f64> =
                numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
            let (rows, []) = numbers.as_chunks() else {
                let columns = EpisodeRecord::COLUMNS;
                return Err(format!("a piece of the records is no table of {columns} columns"));
            };
            for row in rows {
                let record = EpisodeRecord::from_row(row);
                let number = records.len();
                records.push(record.ok_or_else(|| format!("no episode is as record {number}"))?);
            }
        }
        Ok(records)
    }

    /// A list of whole numbers.
    fn column(&self, name: &str) -> Result<Vec<u32>, String> {
        let view = self.tensors.tensor(name).map_err(|_| format!("{name} is missing"))?;
        match view.data().as_chunks() {
            (numbers, []) if view.dtype() == Dtype::U32 && view.shape().len() == 1 => {
                Ok(numbers.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect())
            }
            _ => Err(format!("{name} is no list of 32-bit numbers")),
        }
    }
}

/// A checksum of a state and of tensors, which come in the order of their names.
fn checksum<'a, V: View + 'a>(state: &str, tensors: impl Iterator<Item = (&'a str, &'a V)>) -> u32 {
    static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISCSI);
    let mut digest = CRC.digest();
    digest.update(state.as_bytes());
    for (name, tensor) in tensors {
        digest.update(format!("{name} {:?} {:?}", tensor.dtype(), tensor.shape()).as_bytes());
        digest.update(&tensor.data());
    }
    digest.finalize()
}

fn damaged(path: &Path, reason: impl ToString) -> LoadError {
    LoadError::Damaged { path: path.display().to_string(), reason: reason.to_string() }
}

fn does_not_fit(path: &Path, reason: impl ToString) -> LoadError {
    LoadError::DoesNotFit { path: path.display().to_string(), reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Preset;

    fn plan() -> Plan {
        Plan { scenario: "empty".into(), episodes: 10, seed: 3, rooms: 2 }
    }

    fn bytes_of(training: &Training) -> Vec<u8> {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("checkpoint.safetensors");
        training.write_checkpoint(&file).unwrap();
        std::fs::read(file).unwrap()
    }

    fn load(bytes: &[u8], plan: Plan, settings: Settings) -> Result<Training, String> {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("checkpoint.safetensors");
        std::fs::write(&file, bytes).unwrap();
        Training::load(&file, plan, settings).map_err(|error| error.to_string())
    }

    /// The file with another text in its state.
    fn with_state(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
        let (length, rest) = bytes.split_at(8);
        let length = u64::from_le_bytes(length.try_into().unwrap()) as usize;
        let (header, tensors) = rest.split_at(length);
        // The state is a JSON text within the header's JSON.
        let escaped = |text: &str| text.replace('"', "\\\"");
        let header = std::str::from_utf8(header).unwrap();
        assert!(header.contains(&escaped(from)), "no {from} in the checkpoint");
        let header = header.replace(&escaped(from), &escaped(to));
        sealed(&[&(header.len() as u64).to_le_bytes(), header.as_bytes(), tensors].concat())
    }

    /// The file with the checksum that belongs to it now.
    fn sealed(bytes: &[u8]) -> Vec<u8> {
        let file = File::parse(Path::new("test"), bytes).unwrap();
        let (written, state) = file.metadata[METADATA_KEY].split_once(' ').unwrap();
        let mut views: Vec<_> = file.tensors.iter().collect();
        views.sort_by_key(|(name, _)| *name);
        let right = checksum(state, views.iter().map(|(name, view)| (*name, view)));
        let right = format!("{right:08x}");
        let place = bytes.windows(8).position(|eight| eight == written.as_bytes()).unwrap();
        let mut bytes = bytes.to_vec();
        bytes[place..place + 8].copy_from_slice(right.as_bytes());
        bytes
    }

    /// Whatever became of a byte on its way to the disk and back.
    #[test]
    fn no_damage_goes_unnoticed() {
        let settings = Preset::Paper.settings();
        let bytes = bytes_of(&Training::new(plan(), settings.clone()).unwrap());
        let step = bytes.len() / 300;
        for place in (0..bytes.len()).step_by(step) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1 << (place % 8);
            let Err(message) = load(&damaged, plan(), settings.clone()) else {
                panic!("a change of byte {place} is accepted");
            };
            assert!(message.contains("checkpoint.safetensors"), "{message}");
        }
    }

    #[test]
    fn a_checkpoint_of_another_training_is_refused_by_what_differs() {
        let settings = Preset::Paper.settings();
        let bytes = bytes_of(&Training::new(plan(), settings.clone()).unwrap());
        assert!(load(&bytes, plan(), settings.clone()).is_ok());
        let message = |plan, settings| load(&bytes, plan, settings).unwrap_err();
        let other = Plan { seed: 4, ..plan() };
        assert!(message(other, settings.clone()).ends_with("does not fit: its seed is 3, not 4"));
        let other = Plan { rooms: 3, ..plan() };
        let text = message(other, settings.clone());
        assert!(text.ends_with("its number of simulators is 2, not 3"), "{text}");
        let other = Settings { discount: 0.9, batch_size: 32, ..settings };
        let message = message(plan(), other);
        assert!(message.contains("its batch_size is 50, not 32"), "{message}");
        assert!(message.contains("its discount is 0.999, not 0.9"), "{message}");
    }

    #[test]
    fn numbers_that_no_training_has_are_refused() {
        let settings = Preset::Paper.settings();
        let bytes = bytes_of(&Training::new(plan(), settings.clone()).unwrap());
        assert!(load(&with_state(&bytes, "empty", "empty"), plan(), settings.clone()).is_ok());
        let version = format!(r#""version":{VERSION}"#);
        for (from, to) in [
            (r#""wall":{"secs":0"#, r#""wall":{"secs":18446744073709551615"#),
            (r#""first_image":0"#, r#""first_image":18446744073709551000"#),
            (r#""first_image":0"#, r#""first_image":x"#),
            (r#""total_steps":0"#, r#""total_steps":18446744073709551000"#),
            (r#""adam_step":0"#, r#""adam_step":7"#),
            (r#""rooms":2"#, r#""rooms":3"#),
            (r#""next_episode":2"#, r#""next_episode":3"#),
            (r#""episode":1,"image":null"#, r#""episode":2,"image":null"#),
            (r#""episode":1,"image":null"#, r#""episode":1,"image":0"#),
            (r#""begun":null"#, r#""begun":{"actions":[1],"updates":0}"#),
            (version.as_str(), r#""version":2"#),
            (r#""replay_position":"0""#, r#""replay_position":"y""#),
        ] {
            let result = load(&with_state(&bytes, from, to), plan(), settings.clone());
            assert!(result.is_err(), "{to} is accepted");
        }
        for cut in [0, 7, 8, 100, bytes.len() / 2, bytes.len() - 1] {
            assert!(load(&bytes[..cut], plan(), settings.clone()).is_err(), "{cut} bytes");
        }
    }

    #[test]
    fn the_records_of_a_long_training_come_back_in_their_order() {
        let (plan, settings) = (Plan { episodes: 5000, ..plan() }, Preset::Paper.settings());
        let mut training = Training::new(plan.clone(), settings.clone()).unwrap();
        let begun = training.progress.next_episode;
        for episode in 0..2500 {
            training.progress.records.push(EpisodeRecord {
                episode,
                steps: episode + 1,
                episode_return: -0.1 * episode as f32,
                epsilon: 1.0 / f64::from(episode + 1),
                loss: (episode > 100).then(|| f64::from(episode).sqrt()),
                blocked: episode / 3,
                terminated: episode % 2 == 0,
            });
        }
        training.progress.next_episode = begun + 2500;
        let bytes = bytes_of(&training);
        let loaded = load(&bytes, plan.clone(), settings.clone()).unwrap();
        assert_eq!(loaded.progress, training.progress);
        // Not a record more or fewer.
        training.progress.next_episode += 1;
        let message = load(&bytes_of(&training), plan, settings).unwrap_err();
        assert!(message.contains("more or fewer episodes"), "{message}");
    }
}
