use candle_core::{D, Device, Tensor, Var};
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use task::{Action, Image, Random, Step};

use super::*;
use crate::{
    dyna_q::DynaQ,
    network::QNetwork,
    replay_memory::Experience,
    settings::{Preset, Settings, TargetUpdate},
};

/// The networks of the presets, and such as fit no tile: one layer, odd widths, wide ones.
fn shapes() -> Vec<Vec<usize>> {
    let presets = Preset::ALL.iter().map(|preset| preset.settings().network.hidden_layers);
    presets.chain([vec![], vec![1], vec![33], vec![7, 100, 18, 48]]).collect()
}

fn network(hidden: &[usize], seed: u8) -> QNetwork {
    network_of(Image::BYTES, hidden, seed)
}

fn network_of(inputs: usize, hidden: &[usize], seed: u8) -> QNetwork {
    let mut random = Random::from_key([seed.into(); 4]);
    QNetwork::new(inputs, hidden, &mut random).unwrap().randomized(seed)
}

fn random_inputs(batch: usize, seed: u8) -> Vec<f32> {
    let mut random = Random::from_key([seed.into(); 4]);
    (0..batch * Image::BYTES).map(|_| f32::from(random.word() as u8) / 255.0).collect()
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
/// weights; Adam's moments are each one's own all the way. Where a sum is so close to 0 that rounding
/// decides on which side of it a ReLU is, two correct updates part, by a sample's part in the
/// gradient; then Adam's mean of the gradients forgets it.
#[test]
fn the_update_is_candles_autograd_and_adam() {
    let double_q = Preset::Robust.settings().with(|s| s.target.double_q = true);
    let presets = Preset::ALL.map(Preset::settings).into_iter().chain([double_q]);
    let odd = shapes().into_iter().map(|hidden_layers| {
        Preset::Paper.settings().with(|s| s.network.hidden_layers = hidden_layers)
    });
    for settings in presets.chain(odd) {
        // Eq. 6 is another test's, and would move the target network between the two updates.
        let settings = settings.with(|s| {
            s.replay.capacity = 300;
            s.target.update_at = TargetUpdate::Episode;
        });
        let hidden = &settings.network.hidden_layers;
        let mut learner = DynaQ::new(settings.clone(), 4, 1).unwrap();
        let inputs = input_size(settings.network.observation_frames);
        let (train, target) = (network_of(inputs, hidden, 5), network_of(inputs, hidden, 6));
        learner.train.read(&train).unwrap();
        learner.target.read(&target).unwrap();
        remember_anything(&mut learner, 300);
        let mut reference = Reference::new(&train, target, &settings);
        let (mut tolerance, mut parted) = (0.0, 0);
        for update in 0..300 {
            assert!(learner.draw(0));
            let (expected, relus) = reference.update(&learner);
            let loss = learner.update();
            let parts = relus != relus_of(&learner);
            parted += usize::from(parts);
            tolerance = if parts { 1e-6 } else { tolerance * settings.optimizer.beta1 };
            let error = (loss / expected - 1.0).abs();
            assert!(error < 1e-5, "{hidden:?}, update {update}: {loss}, candle {expected}");
            let ours = learner.train.network().unwrap();
            for ((name, ours), theirs) in ours.tensors().zip(&reference.variables) {
                let difference = (ours - theirs.as_tensor()).unwrap().abs().unwrap();
                let mean: f32 = difference.mean_all().unwrap().to_scalar().unwrap();
                // An update moves a weight by up to 1e-4.
                let most = 1e-8 + tolerance;
                assert!(f64::from(mean) < most, "{hidden:?}, update {update}, {name}: {mean} off");
                theirs.set(ours).unwrap();
            }
        }
        assert!(parted <= 30, "{hidden:?}: {parted} of 300 updates parted");
    }
}

/// Vectors of any width, or none, give the same result to the last bit.
#[test]
fn the_update_is_the_same_on_every_processor() {
    let result = |arch: Arch| {
        let settings = Preset::Paper.settings().with(|s| {
            s.network.hidden_layers = vec![30, 65];
            s.replay.capacity = 100;
        });
        let mut learner = DynaQ::new(settings, 4, 1).unwrap();
        learner.train.read(&network(&[30, 65], 5)).unwrap();
        learner.set_arch(arch);
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
    let mut results = arches().map(result);
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
        // Now and then nothing is to be seen of an action.
        let image = if number % 4 == 3 { last.clone() } else { image() };
        last = image.clone();
        let (truncated, blocked) = (false, number % 5 == 0);
        let step = Step { image, reward, terminated, truncated, blocked };
        state = learner.remember(state, action.try_into().unwrap(), &step);
        if terminated {
            state = learner.begin_episode(&last);
        }
    }
}

/// The update as candle makes it.
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
            train: QNetwork::from_layers(layers).unwrap(),
            adam: AdamW::new(variables.clone(), parameters).unwrap(),
            variables,
            target,
            settings: settings.clone(),
        }
    }

    /// Returns the loss, and which ReLUs of the training network are open for the states.
    fn update(&mut self, learner: &DynaQ) -> (f32, Vec<bool>) {
        let (memory, views, device) = (&learner.memory, &learner.views, &Device::Cpu);
        let experiences: Vec<Experience> =
            learner.batch.iter().map(|index| memory.get(*index)).collect();
        let rows = experiences.len();
        let frames = self.settings.network.observation_frames;
        let observations = |number: fn(&Experience) -> u64| {
            let numbers = experiences.iter().map(number);
            let inputs: Vec<f32> = numbers
                .zip(views)
                .flat_map(|(number, view)| {
                    observation(&memory.past(number).collect::<Vec<_>>(), frames, *view)
                })
                .collect();
            Tensor::from_vec(inputs, (rows, input_size(frames)), device).unwrap()
        };
        let column = |value: &dyn Fn(&Experience) -> f32| {
            Tensor::new(experiences.iter().map(value).collect::<Vec<f32>>(), device).unwrap()
        };
        let (states, next_states) = (observations(|e| e.state), observations(|e| e.next_state));
        let rewards = column(&|experience| experience.reward);
        let discount = self.settings.target.discount as f32;
        let discounts = column(&|experience| if experience.terminated { 0.0 } else { discount });
        let actions: Vec<u32> = experiences
            .iter()
            .zip(views)
            .map(|(experience, view)| u32::from(view.action(experience.action).index()))
            .collect();
        let actions = Tensor::from_vec(actions, (rows, 1), device).unwrap();
        // What has been tried is never the best.
        let tried: Vec<f32> = experiences
            .iter()
            .zip(views)
            .flat_map(|(experience, view)| {
                let tried = view.actions(memory.frame(experience.next_state).tried);
                let avoids = self.settings.exploration.avoid_repetition;
                Action::ALL
                    .into_iter()
                    .map(move |a| if avoids && tried.contains(a) { -1e9 } else { 0.0 })
            })
            .collect();
        let tried = Tensor::from_vec(tried, (rows, Action::COUNT), device).unwrap();
        let loss = || {
            let next_values = self.target.forward(&next_states)?;
            let chooser = if self.settings.target.double_q { &self.train } else { &self.target };
            let best = (chooser.forward(&next_states)? + tried)?.argmax_keepdim(D::Minus1)?;
            let best_next = next_values.gather(&best, 1)?.squeeze(1)?.detach();
            let targets = (&rewards + (&discounts * best_next)?)?;
            let values = self.train.forward(&states)?.gather(&actions, 1)?.squeeze(1)?;
            (targets - values)?.sqr()?.mean_all()
        };
        let relus = open_relus(&self.train, &states);
        let loss = loss().unwrap();
        self.adam.backward_step(&loss).unwrap();
        (loss.to_scalar().unwrap(), relus)
    }
}

/// Which hidden outputs are above 0: of each layer, of each sample.
fn open_relus(network: &QNetwork, inputs: &Tensor) -> Vec<bool> {
    let mut open = Vec::new();
    let mut values = inputs.clone();
    let layers: Vec<_> = network.layers().collect();
    for (weight, bias) in &layers[..layers.len() - 1] {
        let products = values.matmul(&weight.t().unwrap()).unwrap();
        values = products.broadcast_add(bias).unwrap().relu().unwrap();
        let numbers: Vec<f32> = values.flatten_all().unwrap().to_vec1().unwrap();
        open.extend(numbers.into_iter().map(|number| number > 0.0));
    }
    open
}

/// The same of the learner's latest update.
fn relus_of(learner: &DynaQ) -> Vec<bool> {
    let layers = &learner.train.layers;
    let hidden = layers[..layers.len() - 1].iter().zip(&learner.batch_activations.outputs);
    let rows = hidden.flat_map(|(layer, outputs)| {
        outputs.chunks_exact(layer.width()).flat_map(|row| &row[..layer.outputs])
    });
    rows.map(|output| *output > 0.0).collect()
}

/// An observation, number by number.
fn observation(past: &[Moment], frames: usize, view: View) -> Vec<f32> {
    let seen = past.len().min(frames).min(view.frames);
    let mut input = vec![0.0; input_size(frames)];
    for (frame, moment) in past[..seen].iter().enumerate() {
        for row in 0..Image::HEIGHT {
            for column in 0..Image::WIDTH {
                let from = if view.mirrored { Image::WIDTH - 1 - column } else { column };
                for channel in 0..3 {
                    let byte = moment.image[(row * Image::WIDTH + from) * 3 + channel];
                    let place = ((frame * Image::HEIGHT + row) * Image::WIDTH + column) * 3;
                    input[place + channel] = f32::from(byte) / 255.0;
                }
            }
        }
        if frame + 1 < seen {
            let action = usize::from(moment.action.unwrap().index());
            let action = if view.mirrored { Action::COUNT - 1 - action } else { action };
            input[frames * Image::BYTES + frame * Action::COUNT + action] = 1.0;
        }
    }
    input
}
