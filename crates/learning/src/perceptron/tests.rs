use candle_core::{D, Device, Tensor, Var};
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use task::{Action, Image, Random, Step};

use super::*;
use crate::{
    dyna_q::DynaQ,
    network::{QNetwork, Shape},
    observation::{Augmentation, Moment, input_size},
    replay_memory::Transition,
    settings::{Architecture, Preset, Settings, TargetUpdate},
};

/// Returns the shapes of the presets, and others with sizes that do not divide into whole tiles.
fn shapes() -> Vec<Shape> {
    let presets = Preset::ALL.iter().map(|preset| Shape::of(&preset.settings().network));
    let plain = [vec![], vec![1], vec![33], vec![7, 100, 18, 48]].map(|layers| shape(&layers));
    let shared = [vec![5], vec![33, 20]].map(|layers| Shape { parts: 3, ..shape(&layers) });
    presets.chain(plain).chain(shared).collect()
}

/// Returns the shape of a multilayer perceptron for one image.
fn shape(hidden_layers: &[usize]) -> Shape {
    Shape { inputs: Image::BYTES, parts: 1, hidden_layers: hidden_layers.to_vec() }
}

fn network(shape: &Shape, seed: u8) -> QNetwork {
    let mut random = Random::from_key([seed.into(); 4]);
    QNetwork::new(shape, &mut random).unwrap().randomized(seed)
}

fn random_inputs(count: usize, seed: u8) -> Vec<f32> {
    let mut random = Random::from_key([seed.into(); 4]);
    (0..count).map(|_| f32::from(random.word() as u8) / 255.0).collect()
}

fn set_inputs(activations: &mut Activations, inputs: &[f32]) {
    let size = inputs.len() / activations.batch();
    for (to, from) in activations.inputs_mut().zip(inputs.chunks_exact(size)) {
        to.copy_from_slice(from);
    }
}

#[test]
fn the_forward_pass_matches_candle() {
    for shape in shapes() {
        for batch in [1, 4, 50, 53] {
            let network = network(&shape, 1);
            let perceptron = Perceptron::new(&network).unwrap();
            let inputs = random_inputs(batch * shape.inputs, 2);
            let mut activations = perceptron.activations(batch);
            set_inputs(&mut activations, &inputs);
            perceptron.forward(&mut activations);
            let tensor = Tensor::from_vec(inputs, (batch, shape.inputs), &Device::Cpu).unwrap();
            let expected: Vec<Vec<f32>> = network.forward(&tensor).unwrap().to_vec2().unwrap();
            assert_eq!(activations.outputs().count(), batch);
            for (values, expected) in activations.outputs().zip(expected) {
                for (value, expected) in values.iter().zip(expected) {
                    let scale = expected.abs().max(1.0);
                    assert!(
                        (value - expected).abs() < 1e-5 * scale,
                        "{shape:?}: {value}, not {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn weights_survive_the_conversion() {
    for shape in shapes() {
        let network = network(&shape, 3);
        let converted = Perceptron::new(&network).unwrap().network().unwrap();
        for ((name, before), (_, after)) in network.tensors().zip(converted.tensors()) {
            let numbers = |tensor: &Tensor| tensor.flatten_all().unwrap().to_vec1::<f32>().unwrap();
            assert_eq!(numbers(before), numbers(after), "{name}");
            assert_eq!(before.dims(), after.dims());
        }
    }
}

/// Compares hundreds of updates with candle's autograd and candle-nn's Adam. Each update starts
/// from the same weights; Adam's moments are never synchronized. If the input of a ReLU is so close
/// to 0 that rounding determines its sign, two correct gradients differ by the contribution of one
/// sample. The difference then decays with Adam's running mean of the gradients.
#[test]
fn the_update_matches_candle() {
    let double_q = Preset::Robust.settings().with(|s| s.target.double_q = true);
    let presets = Preset::ALL.map(Preset::settings).into_iter().chain([double_q]);
    let odd = shapes().into_iter().filter(|shape| shape.inputs == Image::BYTES).map(|shape| {
        Preset::Paper.settings().with(|s| s.network.hidden_layers = shape.hidden_layers)
    });
    let shared = Preset::Paper.settings().with(|s| {
        s.network.architecture = Architecture::SharedEncoder;
        s.network.observation_frames = 3;
        s.network.hidden_layers = vec![18, 20];
    });
    for settings in presets.chain(odd).chain([shared]) {
        // Eq. 6 has a separate test; here, it would move the target network between the two
        // updates.
        let settings = settings.with(|s| {
            s.replay.capacity = 300;
            s.target.update_at = TargetUpdate::Episode;
        });
        let shape = Shape::of(&settings.network);
        let mut learner = DynaQ::new(settings.clone(), 4, 1).unwrap();
        let (train, target) = (network(&shape, 5), network(&shape, 6));
        set_networks(&mut learner, [&train, &target]);
        store_random_transitions(&mut learner, 300);
        let mut reference = Reference::new(&train, target, &settings);
        let (mut tolerance, mut differing) = (0.0, 0);
        for update in 0..300 {
            assert!(learner.sample(0));
            let (expected, relus) = reference.update(&learner);
            let loss = learner.update();
            let differs = relus != relus_of(&learner, &shape);
            differing += usize::from(differs);
            tolerance = if differs { 1e-6 } else { tolerance * settings.optimizer.beta1 };
            let error = (loss / expected - 1.0).abs();
            assert!(error < 1e-5, "{shape:?}, update {update}: {loss}, candle {expected}");
            let weights = learner.network().tensors().unwrap();
            for ((name, weight), expected) in weights.iter().zip(&reference.variables) {
                let difference = (weight - expected.as_tensor()).unwrap().abs().unwrap();
                let mean: f32 = difference.mean_all().unwrap().to_scalar().unwrap();
                // The tolerance is far below the size of an update, about the learning rate.
                let most = 1e-8 + tolerance;
                assert!(
                    f64::from(mean) < most,
                    "{shape:?}, update {update}: {name} is off by {mean}"
                );
                expected.set(weight).unwrap();
            }
        }
        assert!(differing <= 30, "{shape:?}: the ReLUs differ in {differing} of 300 updates");
    }
}

#[test]
fn the_update_is_identical_with_all_vector_instructions() {
    let result = |arch: Arch| {
        let settings = Preset::Paper.settings().with(|s| {
            s.network.hidden_layers = vec![30, 65];
            s.replay.capacity = 100;
        });
        let mut learner = DynaQ::new(settings, 4, 1).unwrap();
        let network = network(&shape(&[30, 65]), 5);
        set_networks(&mut learner, [&network, &network]);
        learner.set_arch(arch);
        store_random_transitions(&mut learner, 100);
        let losses: Vec<u32> = (0..20).map(|_| learner.plan().unwrap().to_bits()).collect();
        let weights: Vec<u32> = learner
            .network()
            .tensors()
            .unwrap()
            .into_iter()
            .flat_map(|(_, tensor)| tensor.flatten_all().unwrap().to_vec1::<f32>().unwrap())
            .map(f32::to_bits)
            .collect();
        (losses, weights)
    };
    let mut results = arches().map(result);
    let first = results.next().unwrap();
    for other in results {
        assert_eq!(other.0, first.0);
        assert!(other.1 == first.1, "the weights differ");
    }
}

#[test]
fn a_nan_weight_gives_nan_values() {
    let network = network(&shape(&[64, 128, 64]), 1);
    for layer in 0..4 {
        let mut perceptron = Perceptron::new(&network).unwrap();
        perceptron.layers[layer].parameters[0] = f32::NAN;
        let mut activations = perceptron.activations(1);
        set_inputs(&mut activations, &random_inputs(Image::BYTES, 2));
        perceptron.forward(&mut activations);
        assert!(activations.outputs().next().unwrap()[..7].iter().any(|value| value.is_nan()));
    }
}

#[test]
fn the_target_network_moves_by_tau() {
    let train = Perceptron::new(&network(&shape(&[20]), 1)).unwrap();
    let before = Perceptron::new(&network(&shape(&[20]), 2)).unwrap();
    let mut target = before.clone();
    target.move_towards(&train, 0.1);
    for (layer, (before, train)) in
        target.layers.iter().zip(before.layers.iter().zip(&train.layers))
    {
        let numbers =
            layer.parameters.iter().zip(before.parameters.iter().zip(train.parameters.iter()));
        for (after, (before, train)) in numbers {
            assert!((after - (0.9 * before + 0.1 * train)).abs() < 1e-6);
        }
    }
}

/// Stores `count` random transitions.
fn store_random_transitions(learner: &mut DynaQ, count: usize) {
    let mut random = Random::from_key([9; 4]);
    let mut image = || {
        let bytes: Vec<u8> = (0..Image::BYTES).map(|_| random.word() as u8).collect();
        Image::try_from(bytes.as_slice()).unwrap()
    };
    let mut last = image();
    let mut state = learner.begin_episode(&last);
    for number in 0..count {
        let action = ((number * 5) % 7) as u8;
        let reward = -0.1 * (number % 3) as f32;
        let terminated = number % 11 == 10;
        // Some actions do not change the image.
        let image = if number % 4 == 3 { last.clone() } else { image() };
        last = image.clone();
        let (truncated, blocked) = (false, number % 5 == 0);
        let step = Step { image, reward, terminated, truncated, blocked };
        state = learner.store(state, action.try_into().unwrap(), &step);
        if terminated {
            state = learner.begin_episode(&last);
        }
    }
}

/// The reference: an update computed by candle.
struct Reference {
    variables: Vec<Var>,
    train: QNetwork,
    target: QNetwork,
    adam: AdamW,
    settings: Settings,
}

impl Reference {
    fn new(train: &QNetwork, target: QNetwork, settings: &Settings) -> Reference {
        let variables: Vec<Var> =
            train.tensors().map(|(_, tensor)| Var::from_tensor(tensor).unwrap()).collect();
        let parameters = ParamsAdamW {
            lr: settings.optimizer.learning_rate,
            beta1: settings.optimizer.beta1,
            beta2: settings.optimizer.beta2,
            eps: settings.optimizer.epsilon,
            weight_decay: settings.optimizer.weight_decay,
        };
        let tensors: Vec<Tensor> =
            variables.iter().map(|variable| variable.as_tensor().clone()).collect();
        let layers = tensors.chunks_exact(2).map(|pair| Ok([pair[0].clone(), pair[1].clone()]));
        Reference {
            train: QNetwork::from_layers(train.parts(), layers).unwrap(),
            adam: AdamW::new(variables.clone(), parameters).unwrap(),
            variables,
            target,
            settings: settings.clone(),
        }
    }

    /// Updates the training network. Returns the loss, and whether each ReLU is active.
    fn update(&mut self, learner: &DynaQ) -> (f32, Vec<bool>) {
        let (memory, augmentations) = (&learner.memory, &learner.augmentations);
        let device = &Device::Cpu;
        let transitions: Vec<Transition> =
            learner.batch.iter().map(|index| memory.get(*index)).collect();
        let rows = transitions.len();
        let frames = self.settings.network.observation_frames;
        let observations = |number: fn(&Transition) -> u64| {
            let numbers = transitions.iter().map(number);
            let inputs: Vec<f32> = numbers
                .zip(augmentations)
                .flat_map(|(number, augmentation)| {
                    observation(&memory.past(number).collect::<Vec<_>>(), frames, *augmentation)
                })
                .collect();
            Tensor::from_vec(inputs, (rows, input_size(frames)), device).unwrap()
        };
        let column = |value: &dyn Fn(&Transition) -> f32| {
            Tensor::new(transitions.iter().map(value).collect::<Vec<f32>>(), device).unwrap()
        };
        let (states, next_states) = (observations(|e| e.state), observations(|e| e.next_state));
        let rewards = column(&|transition| transition.reward);
        let discount = self.settings.target.discount as f32;
        let discounts = column(&|transition| if transition.terminated { 0.0 } else { discount });
        let actions: Vec<u32> = transitions
            .iter()
            .zip(augmentations)
            .map(|(transition, augmentation)| augmentation.action(transition.action).index().into())
            .collect();
        let actions = Tensor::from_vec(actions, (rows, 1), device).unwrap();
        // Excluded actions are never selected.
        let exclusions: Vec<f32> = transitions
            .iter()
            .zip(augmentations)
            .flat_map(|(transition, augmentation)| {
                let tried = augmentation.actions(memory.frame(transition.next_state).tried);
                let avoids = self.settings.exploration.avoid_repetition;
                Action::ALL
                    .into_iter()
                    .map(move |a| if avoids && tried.contains(a) { -1e9 } else { 0.0 })
            })
            .collect();
        let exclusions = Tensor::from_vec(exclusions, (rows, Action::COUNT), device).unwrap();
        let mut weights = vec![1.0; rows];
        if let Some(priorities) = &learner.priorities {
            let beta = self.settings.replay.importance_exponent;
            priorities.importance_weights(&learner.batch, beta, &mut weights);
        }
        let weights = Tensor::new(weights, device).unwrap();
        let loss = || {
            let next_values = self.target.forward(&next_states)?;
            let selector = if self.settings.target.double_q { &self.train } else { &self.target };
            let best = (selector.forward(&next_states)? + exclusions)?.argmax_keepdim(D::Minus1)?;
            let best_next = next_values.gather(&best, 1)?.squeeze(1)?.detach();
            let targets = (&rewards + (&discounts * best_next)?)?;
            let values = self.train.forward(&states)?.gather(&actions, 1)?.squeeze(1)?;
            let squares = (targets - values)?.sqr()?;
            (squares * &weights)?.mean_all()
        };
        let relus = active_relus(&self.train, &states);
        let loss = loss().unwrap();
        self.adam.backward_step(&loss).unwrap();
        (loss.to_scalar().unwrap(), relus)
    }
}

/// Returns whether each hidden output is positive, ordered by layer, then by sample.
fn active_relus(network: &QNetwork, inputs: &Tensor) -> Vec<bool> {
    let mut active = Vec::new();
    let (batch, count) = inputs.dims2().unwrap();
    let parts = network.parts();
    let mut values = inputs.reshape((batch * parts, count / parts)).unwrap();
    let layers: Vec<_> = network.layers().collect();
    for (weight, bias) in &layers[..layers.len() - 1] {
        let products = values.matmul(&weight.t().unwrap()).unwrap();
        values = products.broadcast_add(bias).unwrap().relu().unwrap();
        let numbers: Vec<f32> = values.flatten_all().unwrap().to_vec1().unwrap();
        active.extend(numbers.into_iter().map(|number| number > 0.0));
        values = values.reshape((batch, ())).unwrap();
    }
    active
}

/// Returns whether each ReLU was active in the learner's latest update, in the same order as
/// [`active_relus`].
fn relus_of(learner: &DynaQ, shape: &Shape) -> Vec<bool> {
    let activations = &learner.batch_activations;
    let layers = shape.hidden_layers.iter().zip(&activations.outputs).enumerate();
    let rows = layers.flat_map(|(layer, (neurons, outputs))| {
        let parts = if layer == 0 { shape.parts } else { 1 };
        let width = outputs.len() / activations.batch() / parts;
        outputs.chunks_exact(width).flat_map(|row| &row[..*neurons])
    });
    rows.map(|output| *output > 0.0).collect()
}

/// Sets the weights of the training network and the target network.
fn set_networks(learner: &mut DynaQ, networks: [&QNetwork; 2]) {
    for ((_, to), from) in learner.backend.networks_mut().into_iter().zip(networks) {
        let tensors = from.tensors().map(|(name, tensor)| (name, tensor.clone())).collect();
        to.read("", &tensors).unwrap();
    }
}

/// Computes an observation element by element, as a reference.
fn observation(past: &[Moment], frames: usize, augmentation: Augmentation) -> Vec<f32> {
    let count = past.len().min(frames).min(augmentation.frames);
    let mut input = vec![0.0; input_size(frames)];
    let row_size = input.len() / frames;
    for (frame, moment) in past[..count].iter().enumerate() {
        for row in 0..Image::HEIGHT {
            for column in 0..Image::WIDTH {
                let from = if augmentation.mirrored { Image::WIDTH - 1 - column } else { column };
                for channel in 0..3 {
                    let byte = moment.image[(row * Image::WIDTH + from) * 3 + channel];
                    let index = (row * Image::WIDTH + column) * 3 + channel;
                    input[frame * row_size + index] = f32::from(byte) / 255.0;
                }
            }
        }
        if frame + 1 < count {
            let action = usize::from(moment.action.unwrap().index());
            let action = if augmentation.mirrored { Action::COUNT - 1 - action } else { action };
            input[frame * row_size + Image::BYTES + action] = 1.0;
        }
    }
    input
}
