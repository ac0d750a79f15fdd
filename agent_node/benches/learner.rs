//! The learner's part of a step, by what it is made of: `cargo bench --package agent_node`.
//!
//! Preset `paper`, with a full memory.

use agent_node::learning::{
    action::Action,
    dyna_q::DynaQ,
    image::Image,
    network::QNetwork,
    perceptron::Perceptron,
    replay_memory::ReplayMemory,
    seeds::{self, Sequence},
    settings::{Preset, Settings},
};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

fn settings() -> Settings {
    Preset::Paper.settings()
}

/// An image unlike those of other numbers.
fn image(number: usize) -> Image {
    let bytes: Vec<u8> = (0..Image::BYTES).map(|index| (number * 31 + index * 7) as u8).collect();
    Image::try_from(bytes.as_slice()).expect("it has the size of an image")
}

/// Actions, rewards, ends and images to remember.
fn experiences() -> impl Iterator<Item = (Action, f32, bool, Image)> {
    (1..=settings().memory_capacity).map(|number| {
        let action = Action::try_from((number % Action::COUNT) as u8).expect("below the count");
        (action, -0.1, number % 40 == 0, image(number))
    })
}

fn learner() -> DynaQ {
    let mut learner = DynaQ::new(settings(), 0, 1).expect("the preset describes a network");
    let mut state = learner.begin_episode(&image(0));
    for (action, reward, terminated, next) in experiences() {
        state = learner.remember(state, action, reward, terminated, &next);
    }
    learner
}

/// The whole update: the draw, the batch, three passes and Adam.
#[divan::bench(sample_size = 100)]
fn update(bencher: Bencher) {
    let mut learner = learner();
    bencher.bench_local(|| learner.plan());
}

/// The values of one state, and the choice by them.
#[divan::bench(sample_size = 1000)]
fn inference(bencher: Bencher) {
    let (mut learner, image) = (learner(), image(5));
    bencher.bench_local(|| learner.act(&[(black_box(&image), 0.0)]));
}

/// The indices of a batch.
#[divan::bench(sample_size = 1000)]
fn draw(bencher: Bencher) {
    let mut memory = ReplayMemory::new(settings().memory_capacity, 1);
    let mut state = memory.begin_episode(&image(0));
    for (action, reward, terminated, next) in experiences() {
        state = memory.store(state, action, reward, terminated, &next);
    }
    let mut batch = vec![0; settings().batch_size];
    let mut random = seeds::sequence(0, Sequence::Replay);
    bencher.bench_local(|| memory.draw(&mut batch, 0, &mut random));
}

/// The images of a batch as a network's inputs.
#[divan::bench(sample_size = 1000)]
fn images(bencher: Bencher) {
    let mut random = seeds::sequence(0, Sequence::Weights);
    let network = QNetwork::new(&settings().hidden_layers, &mut random);
    let perceptron = network.and_then(|network| Perceptron::new(&network));
    let mut activations =
        perceptron.expect("the preset describes a network").activations(settings().batch_size);
    let images: Vec<Image> = (0..settings().batch_size).map(image).collect();
    bencher.bench_local(|| activations.read_images(black_box(&images).iter().map(Image::bytes)));
}
