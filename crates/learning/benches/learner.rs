//! Benchmarks of the operations that the learner performs in each step. Run them with
//! `cargo bench --package learning`.
//!
//! Each benchmark runs with both presets. If it uses a replay memory, the replay memory is full.

use divan::{Bencher, black_box};
use learning::{
    backend::Network,
    dyna_q::DynaQ,
    network::{QNetwork, Shape},
    observation::{Augmentation, History},
    perceptron::Perceptron,
    priorities::Priorities,
    replay_memory::ReplayMemory,
    sequence::Sequence,
    settings::{Preset, Settings},
};
use task::{Action, Image, Step};

fn main() {
    divan::main();
}

/// Returns an image whose bytes depend on `number`.
fn image(number: usize) -> Image {
    let bytes: Vec<u8> = (0..Image::BYTES).map(|index| (number * 31 + index * 7) as u8).collect();
    Image::try_from(bytes.as_slice()).expect("the buffer has the size of an image")
}

/// Returns enough actions and steps to fill the replay memory.
fn transitions(settings: &Settings) -> impl Iterator<Item = (Action, Step)> {
    (1..=settings.replay.capacity).map(|number| {
        let action = Action::try_from((number % Action::COUNT) as u8)
            .expect("the index is below the number of actions");
        let (terminated, blocked) = (number % 40 == 0, number % 9 == 0);
        let image = image(number);
        (action, Step { image, reward: -0.1, terminated, truncated: false, blocked })
    })
}

/// Returns a learner with a full replay memory.
fn learner(preset: Preset) -> DynaQ {
    let settings = preset.settings();
    let mut learner = DynaQ::new(settings.clone(), 0, 1).expect("the preset describes a network");
    let mut state = learner.begin_episode(&image(0));
    for (action, step) in transitions(&settings) {
        state = learner.store(state, action, &step);
    }
    learner
}

/// Performs an update: samples a batch, reads its observations, and runs two forward passes and one
/// step of Adam.
#[divan::bench(args = Preset::ALL, sample_size = 100)]
fn update(bencher: Bencher, preset: Preset) {
    let mut learner = learner(preset);
    bencher.bench_local(|| learner.plan());
}

/// Computes the action values of one state and selects the greedy action.
#[divan::bench(args = Preset::ALL, sample_size = 1000)]
fn inference(bencher: Bencher, preset: Preset) {
    let mut learner = learner(preset);
    let state = learner.begin_episode(&image(5));
    bencher.bench_local(|| learner.act(&[(black_box(state), 0.0)]));
}

/// Samples the indices of a batch.
#[divan::bench(args = Preset::ALL, sample_size = 1000)]
fn sample(bencher: Bencher, preset: Preset) {
    let settings = preset.settings();
    let (frames, avoid_repetition) =
        (settings.network.observation_frames, settings.exploration.avoid_repetition);
    let mut memory = ReplayMemory::new(settings.replay.capacity, 1, frames, avoid_repetition);
    let mut state = memory.begin_episode(&image(0));
    for (action, Step { reward, terminated, image, .. }) in transitions(&settings) {
        state = memory.store(state, action, reward, terminated, &image);
    }
    let mut batch = vec![0; settings.replay.batch_size];
    let mut random = Sequence::Replay.random(0);
    if settings.replay.priority_exponent == 0.0 {
        bencher.bench_local(|| memory.sample(&mut batch, 0, &mut random));
    } else {
        let mut priorities = Priorities::new(settings.replay.priority_exponent);
        (0..memory.len()).for_each(|index| priorities.announce(index));
        bencher.bench_local(|| priorities.sample(&mut batch, &mut random));
    }
}

/// Converts a batch of observations to network inputs.
#[divan::bench(args = Preset::ALL, sample_size = 1000)]
fn observations(bencher: Bencher, preset: Preset) {
    let Settings { network, replay, .. } = preset.settings();
    let (frames, batch_size) = (network.observation_frames, replay.batch_size);
    let mut random = Sequence::Weights.random(0);
    let network = QNetwork::new(&Shape::of(&network), &mut random);
    let perceptron = network.and_then(|network| Perceptron::new(&network));
    let mut activations =
        perceptron.expect("the preset describes a network").activations(batch_size);
    let mut histories = Vec::new();
    for number in 0..batch_size {
        let mut history = History::new(frames);
        history.begin(image(number));
        (1..frames).for_each(|back| history.push(Action::default(), image(number + back)));
        histories.push(history);
    }
    bencher.bench_local(|| {
        let observations =
            black_box(&histories).iter().map(|history| (history.past(), Augmentation::NONE));
        activations.read_observations(frames, observations);
    });
}
