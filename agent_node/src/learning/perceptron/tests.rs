use candle_core::{D, Device, Tensor, Var};
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use pulp::Arch;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::learning::{
    dyna_q::DynaQ,
    image::Image,
    network::QNetwork,
    settings::{Preset, Settings},
};

/// This processor's vectors, and those of processors that have less.
fn arches() -> Vec<Arch> {
    let mut arches = vec![Arch::new(), Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    arches.extend(pulp::x86::V3::try_new().map(Arch::V3));
    arches
}

/// The networks of the presets, and such as fit no tile: one layer, odd widths, wide ones.
fn shapes() -> Vec<Vec<usize>> {
    let presets = Preset::ALL.iter().map(|preset| preset.settings().hidden_layers);
    presets.chain([vec![], vec![1], vec![33], vec![7, 100, 18, 48]]).collect()
}

fn network(hidden: &[usize], seed: u8) -> QNetwork {
    QNetwork::new(hidden, &mut ChaCha8Rng::from_seed([seed; 32])).unwrap().randomized(seed)
}

fn random_inputs(batch: usize, seed: u8) -> Vec<f32> {
    let mut random = ChaCha8Rng::from_seed([seed; 32]);
    (0..batch * Image::BYTES).map(|_| f32::from(random.random::<u8>()) / 255.0).collect()
}

fn set_inputs(activations: &mut Activations, inputs: &[f32]) {
    for (to, from) in activations.inputs_mut().zip(inputs.chunks_exact(Image::BYTES)) {
        to.copy_from_slice(from);
    }
}

#[test]
fn the_forward_pass_is_candles() {
    for hidden in shapes() {
        for batch in [1, 4, 50, 53] {
            let network = network(&hidden, 1);
            let perceptron = Perceptron::new(&network).unwrap();
            let inputs = random_inputs(batch, 2);
            let mut activations = perceptron.activations(batch);
            set_inputs(&mut activations, &inputs);
            perceptron.forward(&mut activations);
            let tensor = Tensor::from_vec(inputs, (batch, Image::BYTES), &Device::Cpu).unwrap();
            let expected: Vec<Vec<f32>> = network.forward(&tensor).unwrap().to_vec2().unwrap();
            assert_eq!(activations.outputs().count(), batch);
            for (values, expected) in activations.outputs().zip(expected) {
                for (value, expected) in values.iter().zip(expected) {
                    let scale = expected.abs().max(1.0);
                    assert!(
                        (value - expected).abs() < 1e-5 * scale,
                        "{hidden:?} {value} {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_weights_pass_through_unchanged() {
    for hidden in shapes() {
        let network = network(&hidden, 3);
        let back = Perceptron::new(&network).unwrap().network().unwrap();
        for ((name, before), (_, after)) in network.tensors().zip(back.tensors()) {
            let numbers = |tensor: &Tensor| tensor.flatten_all().unwrap().to_vec1::<f32>().unwrap();
            assert_eq!(numbers(before), numbers(after), "{name}");
            assert_eq!(before.dims(), after.dims());
        }
    }
}

/// Hundreds of updates beside candle's autograd and candle-nn's Adam. Each begins from the same
/// weights: from then on a rounding error may decide on which side of 0 a ReLU is, and two correct
/// trainings part. Adam's moments are each one's own all the way.
#[test]
fn the_update_is_candles_autograd_and_adam() {
    for hidden in shapes() {
        let settings = Settings {
            hidden_layers: hidden.clone(),
            memory_capacity: 300,
            ..Preset::Paper.settings()
        };
        let mut learner = DynaQ::new(settings.clone(), 4, 1).unwrap();
        let (train, target) = (network(&hidden, 5), network(&hidden, 6));
        learner.train.read(&train).unwrap();
        learner.target.read(&target).unwrap();
        remember_anything(&mut learner, 300);
        let mut reference = Reference::new(&train, target, &settings);
        for update in 0..300 {
            assert!(learner.draw(0));
            let expected = reference.update(&learner);
            let loss = learner.update();
            let error = (loss / expected - 1.0).abs();
            assert!(error < 1e-5, "{hidden:?}, update {update}: {loss}, candle {expected}");
            let ours = learner.train.network().unwrap();
            for ((name, ours), theirs) in ours.tensors().zip(&reference.variables) {
                let difference = (ours - theirs.as_tensor()).unwrap().abs().unwrap();
                let mean: f32 = difference.mean_all().unwrap().to_scalar().unwrap();
                // An update moves a weight by up to 1e-4.
                assert!(mean < 1e-8, "{hidden:?}, update {update}, {name}: off by {mean}");
                theirs.set(ours).unwrap();
            }
        }
    }
}

/// Vectors of any width, or none, give the same result to the last bit.
#[test]
fn the_update_is_the_same_on_every_processor() {
    let result = |arch: Arch| {
        let settings = Settings {
            hidden_layers: vec![30, 65],
            memory_capacity: 100,
            ..Preset::Paper.settings()
        };
        let mut learner = DynaQ::new(settings, 4, 1).unwrap();
        learner.train.read(&network(&[30, 65], 5)).unwrap();
        learner.train.arch = arch;
        learner.target.arch = arch;
        remember_anything(&mut learner, 100);
        let losses: Vec<u32> = (0..20).map(|_| learner.plan().unwrap().to_bits()).collect();
        let weights: Vec<u32> = learner
            .train
            .layers
            .iter()
            .flat_map(|layer| layer.parameters.iter().map(|weight| weight.to_bits()))
            .collect();
        (losses, weights)
    };
    let mut results = arches().into_iter().map(result);
    let first = results.next().unwrap();
    for other in results {
        assert_eq!(other.0, first.0);
        assert!(other.1 == first.1, "the weights differ");
    }
}

#[test]
fn a_weight_that_is_no_number_shows_in_the_values() {
    let network = network(&[64, 128, 64], 1);
    for layer in 0..4 {
        let mut perceptron = Perceptron::new(&network).unwrap();
        perceptron.layers[layer].parameters[0] = f32::NAN;
        let mut activations = perceptron.activations(1);
        set_inputs(&mut activations, &random_inputs(1, 2));
        perceptron.forward(&mut activations);
        assert!(activations.outputs().next().unwrap()[..7].iter().any(|value| value.is_nan()));
    }
}

#[test]
fn the_target_moves_by_tau() {
    let train = Perceptron::new(&network(&[20], 1)).unwrap();
    let before = Perceptron::new(&network(&[20], 2)).unwrap();
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

/// Random images, actions, rewards and ends.
fn remember_anything(learner: &mut DynaQ, count: usize) {
    let mut random = ChaCha8Rng::from_seed([9; 32]);
    let mut image = || {
        let bytes: Vec<u8> = (0..Image::BYTES).map(|_| random.random()).collect();
        Image::try_from(bytes.as_slice()).unwrap()
    };
    let mut state = learner.begin_episode(&image());
    for number in 0..count {
        let action = ((number * 5) % 7) as u8;
        let reward = -0.1 * (number % 3) as f32;
        let (action, terminated) = (action.try_into().unwrap(), number % 11 == 0);
        state = learner.remember(state, action, reward, terminated, &image());
    }
}

/// The update as candle makes it.
struct Reference {
    variables: Vec<Var>,
    train: QNetwork,
    target: QNetwork,
    adam: AdamW,
    discount: f32,
}

impl Reference {
    fn new(train: &QNetwork, target: QNetwork, settings: &Settings) -> Reference {
        let variables: Vec<Var> =
            train.tensors().map(|(_, tensor)| Var::from_tensor(tensor).unwrap()).collect();
        let parameters = ParamsAdamW {
            lr: settings.learning_rate,
            beta1: settings.adam_beta1,
            beta2: settings.adam_beta2,
            eps: settings.adam_epsilon,
            weight_decay: 0.0,
        };
        let tensors: Vec<Tensor> =
            variables.iter().map(|variable| variable.as_tensor().clone()).collect();
        let layers = tensors.chunks_exact(2).map(|pair| Ok([pair[0].clone(), pair[1].clone()]));
        Reference {
            train: QNetwork::from_layers(layers).unwrap(),
            adam: AdamW::new(variables.clone(), parameters).unwrap(),
            variables,
            target,
            discount: settings.discount as f32,
        }
    }

    /// Returns the loss.
    fn update(&mut self, learner: &DynaQ) -> f32 {
        let (memory, batch) = (&learner.memory, &learner.batch);
        let experiences: Vec<_> = batch.iter().map(|index| memory.get(*index)).collect();
        let images = |number: &dyn Fn(usize) -> u64| {
            let bytes = (0..batch.len()).flat_map(|row| memory.image(number(row)).to_vec());
            let inputs: Vec<f32> = bytes.map(|byte| f32::from(byte) / 255.0).collect();
            Tensor::from_vec(inputs, (batch.len(), Image::BYTES), &Device::Cpu).unwrap()
        };
        let column = |value: &dyn Fn(usize) -> f32| {
            let values: Vec<f32> = (0..batch.len()).map(value).collect();
            Tensor::new(values, &Device::Cpu).unwrap()
        };
        let states = images(&|row| experiences[row].state);
        let next_states = images(&|row| experiences[row].next_state);
        let rewards = column(&|row| experiences[row].reward);
        let discounts =
            column(&|row| if experiences[row].terminated { 0.0 } else { self.discount });
        let actions: Vec<u32> =
            experiences.iter().map(|experience| u32::from(experience.action.index())).collect();
        let actions = Tensor::from_vec(actions, (batch.len(), 1), &Device::Cpu).unwrap();
        let loss = || {
            let best_next = self.target.forward(&next_states)?.max(D::Minus1)?.detach();
            let targets = (&rewards + (&discounts * best_next)?)?;
            let values = self.train.forward(&states)?.gather(&actions, 1)?.squeeze(1)?;
            (targets - values)?.sqr()?.mean_all()
        };
        let loss = loss().unwrap();
        self.adam.backward_step(&loss).unwrap();
        loss.to_scalar().unwrap()
    }
}
