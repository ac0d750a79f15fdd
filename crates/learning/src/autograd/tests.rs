use candle_core::Module;
use task::{Image, Step};

use super::*;
use crate::{
    dyna_q::DynaQ,
    settings::{Architecture, Preset, Settings, TargetUpdate},
};

fn settings(architecture: Architecture) -> Settings {
    Preset::Robust.settings().with(|s| {
        s.network.architecture = architecture;
        s.network.hidden_layers = vec![12, 9];
        s.replay.capacity = 200;
        s.replay.batch_size = 16;
    })
}

/// Returns a network with random weights in all layers, including the output layers.
fn randomized(architecture: Architecture) -> CandleNetwork {
    let mut random = Random::from_key([5; 4]);
    let settings = settings(architecture).network;
    CandleNetwork::with(&settings, &mut |_, shape| normal(shape, 0.1, &mut random)).unwrap()
}

fn inputs(batch: usize) -> Vec<f32> {
    let mut random = Random::from_key([6; 4]);
    (0..batch * input_size(4)).map(|_| random.uniform() as f32).collect()
}

fn outputs(network: &CandleNetwork, inputs: &[f32]) -> Vec<[f32; Action::COUNT]> {
    let mut activations = network.activations(inputs.len() / input_size(4));
    activations.inputs.copy_from_slice(inputs);
    network.forward(&mut activations);
    activations.outputs().map(|values| values.try_into().unwrap()).collect()
}

/// Fills the replay memory with random transitions.
fn fill(learner: &mut DynaQ) {
    let mut random = Random::from_key([7; 4]);
    let mut image = || {
        let bytes: Vec<u8> = (0..Image::BYTES).map(|_| random.word() as u8).collect();
        Image::try_from(bytes.as_slice()).unwrap()
    };
    let mut state = learner.begin_episode(&image());
    for number in 0..200_u8 {
        let reward = -0.1 * f32::from(number % 3);
        let step = Step {
            image: image(),
            reward,
            terminated: number % 11 == 10,
            truncated: false,
            blocked: number % 5 == 0,
        };
        state = learner.store(state, Action::try_from(number % 7).unwrap(), &step);
        if step.terminated {
            state = learner.begin_episode(&image());
        }
    }
}

/// The tolerances allow for rounding errors, since the backends add terms in different orders.
#[test]
fn updates_a_perceptron_like_the_kernels() {
    let settings = settings(Architecture::Mlp).with(|s| s.target.update_at = TargetUpdate::Update);
    let mut kernels = DynaQ::new(settings.clone(), 4, 1).unwrap();
    let mut random = Random::from_key([8; 4]);
    for (_, network) in kernels.backend.networks_mut().into_iter().take(1) {
        let tensors = network.tensors().unwrap().into_iter();
        let tensors = tensors
            .map(|(name, tensor)| (name, normal(tensor.dims(), 0.1, &mut random).unwrap()))
            .collect();
        network.read("", &tensors).unwrap();
    }
    kernels.backend.update_target(1.0);
    let mut candle = DynaQ::new(settings.clone(), 4, 1).unwrap();
    let candle_name = |name: String| name.replace("layers.2.", "output.");
    let weights = kernels.network().tensors().unwrap().into_iter();
    let weights = weights.map(|(name, tensor)| (candle_name(name), tensor)).collect();
    let network = CandleNetwork::from_tensors(&settings.network, "", &weights).unwrap();
    let backend = Autograd::new(network, settings.replay.batch_size, &settings.optimizer);
    candle.backend = Box::new(backend.unwrap());
    candle.batch_activations = candle.backend.train().activations(settings.replay.batch_size);
    fill(&mut kernels);
    fill(&mut candle);
    for update in 0..100 {
        let (loss, expected) = (kernels.plan().unwrap(), candle.plan().unwrap());
        assert!((loss / expected - 1.0).abs() < 1e-4, "update {update}: {loss}, candle {expected}");
    }
    let numbers = |learner: &DynaQ, name: &str| -> Vec<f32> {
        let tensors = learner.backend.target().tensors().unwrap();
        let tensor = tensors.into_iter().find(|(other, _)| other == name).unwrap().1;
        tensor.flatten_all().unwrap().to_vec1().unwrap()
    };
    let (weights, expected) =
        (numbers(&kernels, "layers.2.weight"), numbers(&candle, "output.weight"));
    for (weight, expected) in weights.iter().zip(expected) {
        // A hundred updates move a weight by up to 1e-2.
        assert!((weight - expected).abs() < 1e-5, "{weight}, candle {expected}");
    }
}

/// The brightness of an image determines the reward for every action.
#[test]
fn every_architecture_learns_the_rewards() {
    let image = |number: u8| {
        Image::try_from([80 * (number % 3); Image::BYTES].as_slice()).expect("valid image size")
    };
    for (architecture, frames) in Architecture::ALL.into_iter().flat_map(|a| [(a, 1), (a, 4)]) {
        let settings = settings(architecture).with(|s| {
            s.network.observation_frames = frames;
            s.replay.batch_size = 32;
            s.replay.blocked_reward = 0.0;
            s.target.discount = 0.0;
            s.exploration.avoid_repetition = false;
            s.optimizer.learning_rate = 1e-3;
        });
        let mut learner = DynaQ::new(settings, 3, 1).unwrap();
        let mut state = learner.begin_episode(&image(0));
        for number in 0..200_u8 {
            let reward = -0.1 * f32::from(number % 3);
            let (image, terminated) = (image(number + 1), false);
            let step = Step { image, reward, terminated, truncated: false, blocked: false };
            state = learner.store(state, Action::try_from(number % 7).unwrap(), &step);
        }
        let first = learner.plan().unwrap();
        let mut last = first;
        for _ in 0..200 {
            last = learner.plan().unwrap();
        }
        assert!(last < 0.05 * first, "{architecture}, {frames} frames: {first} to {last}");
    }
}

#[test]
fn initial_values_are_zero() {
    for architecture in Architecture::ALL {
        let mut random = Random::from_key([9; 4]);
        let network = CandleNetwork::new(&settings(architecture).network, &mut random).unwrap();
        assert_eq!(outputs(&network, &inputs(2)), [[0.0; Action::COUNT]; 2], "{architecture}");
    }
}

#[test]
fn a_dueling_head_adds_the_centred_advantages_to_the_value() {
    let network = randomized(Architecture::Dueling);
    let inputs = inputs(1);
    let Model { hidden, head: model::Head::Dueling { value, advantage }, .. } = &network.model
    else {
        panic!("no dueling head");
    };
    let mut hidden_values = Tensor::from_slice(&inputs, (1, inputs.len()), &Device::Cpu).unwrap();
    for layer in hidden {
        hidden_values = layer.forward(&hidden_values).unwrap().relu().unwrap();
    }
    let numbers = |layer: &candle_nn::Linear| -> Vec<f32> {
        layer.forward(&hidden_values).unwrap().flatten_all().unwrap().to_vec1().unwrap()
    };
    let (value, advantage) = (numbers(value)[0], numbers(advantage));
    let mean = advantage.iter().sum::<f32>() / 7.0;
    for (value_of_action, advantage) in outputs(&network, &inputs)[0].iter().zip(advantage) {
        assert!((value_of_action - (value + advantage - mean)).abs() < 1e-6);
    }
}

#[test]
fn every_image_and_action_affects_the_values() {
    for architecture in Architecture::ALL {
        let network = randomized(architecture);
        let inputs = inputs(1);
        let before = outputs(&network, &inputs);
        for frame in 0..4 {
            let mut changed = inputs.clone();
            changed[frame * Image::BYTES..][..Image::BYTES].fill(0.5);
            assert_ne!(outputs(&network, &changed), before, "{architecture}, image {frame}");
        }
        for action in 0..3 {
            let mut changed = inputs.clone();
            changed[4 * Image::BYTES + action * Action::COUNT..][..Action::COUNT].fill(2.0);
            assert_ne!(outputs(&network, &changed), before, "{architecture}, action {action}");
        }
    }
}

#[test]
fn a_clone_does_not_share_its_weights() {
    let network = randomized(Architecture::Recurrent);
    let copy = network.clone();
    let before = outputs(&copy, &inputs(1));
    for (_, weight) in network.variables.iter() {
        weight.set(&weight.zeros_like().unwrap()).unwrap();
    }
    assert_eq!(outputs(&copy, &inputs(1)), before);
    assert_ne!(outputs(&network, &inputs(1)), before);
}

#[test]
fn rejects_tensors_of_another_network() {
    for architecture in Architecture::ALL {
        let network = randomized(architecture);
        let settings = settings(architecture).network;
        let tensors: HashMap<String, Tensor> = network.tensors().unwrap().into_iter().collect();
        let read = |settings: &NetworkSettings, tensors: &HashMap<String, Tensor>| {
            CandleNetwork::from_tensors(settings, "", tensors).map_err(|error| error.to_string())
        };
        let copy = read(&settings, &tensors).unwrap();
        assert_eq!(outputs(&copy, &inputs(1)), outputs(&network, &inputs(1)));
        // A shape that is too large to allocate.
        let huge = NetworkSettings { hidden_layers: vec![1 << 40; 2], ..settings.clone() };
        let message = read(&huge, &tensors).unwrap_err();
        assert!(message.contains("expected: ["), "{message}");
        let (name, _) = network.variables.iter().next().unwrap();
        let mut missing = tensors.clone();
        missing.remove(name);
        let message = read(&settings, &missing).unwrap_err();
        assert!(message.contains(&format!("missing tensor '{name}'")), "{message}");
    }
}

#[test]
fn rejects_a_recurrent_network_without_layers() {
    let settings = settings(Architecture::Recurrent).with(|s| s.network.hidden_layers.clear());
    let message = DynaQ::new(settings, 0, 1).unwrap_err().to_string();
    assert!(message.starts_with("hidden_layers: [] (expected: at least one layer"), "{message}");
}
