//! The learner's part of a step, by what it is made of: `cargo bench --package learning`.
//!
//! Both presets, with a full memory.

use divan::{Bencher, black_box};
use learning::{
    dyna_q::DynaQ,
    network::QNetwork,
    observation::{History, View, input_size},
    perceptron::Perceptron,
    replay_memory::ReplayMemory,
    sequence::Sequence,
    settings::{Preset, Settings},
};
use task::{Action, Image, Step};

fn main() {
    divan::main();
}

/// An image unlike those of other numbers.
fn image(number: usize) -> Image {
    let bytes: Vec<u8> = (0..Image::BYTES).map(|index| (number * 31 + index * 7) as u8).collect();
    Image::try_from(bytes.as_slice()).expect("it has the size of an image")
}

/// Actions and what they led to.
fn experiences(settings: &Settings) -> impl Iterator<Item = (Action, Step)> {
    (1..=settings.replay.capacity).map(|number| {
        let action = Action::try_from((number % Action::COUNT) as u8).expect("below the count");
        let (terminated, blocked) = (number % 40 == 0, number % 9 == 0);
        let image = image(number);
        (action, Step { image, reward: -0.1, terminated, truncated: false, blocked })
    })
}

fn learner(preset: Preset) -> DynaQ {
    let settings = preset.settings();
    let mut learner = DynaQ::new(settings.clone(), 0, 1).expect("the preset describes a network");
    let mut state = learner.begin_episode(&image(0));
    for (action, step) in experiences(&settings) {
        state = learner.remember(state, action, &step);
    }
    learner
}

/// The whole update: the draw, the batch, three passes and Adam.
#[divan::bench(args = Preset::ALL, sample_size = 100)]
fn update(bencher: Bencher, preset: Preset) {
    let mut learner = learner(preset);
    bencher.bench_local(|| learner.plan());
}

/// The values of one state, and the choice by them.
#[divan::bench(args = Preset::ALL, sample_size = 1000)]
fn inference(bencher: Bencher, preset: Preset) {
    let mut learner = learner(preset);
    let state = learner.begin_episode(&image(5));
    bencher.bench_local(|| learner.act(&[(black_box(state), 0.0)]));
}

/// The indices of a batch.
#[divan::bench(args = Preset::ALL, sample_size = 1000)]
fn draw(bencher: Bencher, preset: Preset) {
    let settings = preset.settings();
    let mut memory =
        ReplayMemory::new(settings.replay.capacity, 1, settings.network.observation_frames);
    let mut state = memory.begin_episode(&image(0));
    for (action, Step { reward, terminated, image, .. }) in experiences(&settings) {
        state = memory.store(state, action, reward, terminated, &image);
    }
    let mut batch = vec![0; settings.replay.batch_size];
    let mut random = Sequence::Replay.random(0);
    bencher.bench_local(|| memory.draw(&mut batch, 0, &mut random));
}

/// The observations of a batch as a network's inputs.
#[divan::bench(args = Preset::ALL, sample_size = 1000)]
fn observations(bencher: Bencher, preset: Preset) {
    let Settings { network, replay, .. } = preset.settings();
    let (frames, batch_size) = (network.observation_frames, replay.batch_size);
    let mut random = Sequence::Weights.random(0);
    let network = QNetwork::new(input_size(frames), &network.hidden_layers, &mut random);
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
            black_box(&histories).iter().map(|history| (history.past(), View::PLAIN));
        activations.read_observations(frames, observations);
    });
}
