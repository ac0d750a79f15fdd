//! The deep Q-network of the paper: a multilayer perceptron that maps an observation to seven
//! action values. Optionally, its first layer is shared by the stacked images of an observation.
//!
//! This module initializes the network, names its tensors in files and, for tests, evaluates it
//! with candle. [`perceptron`](crate::perceptron) evaluates it during training and in policies.

use std::collections::HashMap;

use candle_core::{DType, Device, Module, Result, Tensor};
use candle_nn::Linear;
use task::{Action, Random};

use crate::{
    observation::input_size,
    settings::{Architecture, NetworkSettings},
    weights::{WeightsError, normal, saved},
};

/// The error for a network without hidden layers whose architecture needs one.
pub(super) const NO_FIRST_LAYER: &str =
    "hidden_layers: [] (expected: at least one layer, which reads the stacked images)";

/// The sizes of the layers of a [`QNetwork`].
///
/// # Examples
///
/// ```
/// use learning::{network::Shape, settings::Preset};
///
/// let shape = Shape::of(&Preset::Paper.settings().network);
/// assert_eq!(shape, Shape { inputs: 420, parts: 1, hidden_layers: vec![64, 128, 64] });
/// let shape = Shape::of(&Preset::Robust.settings().network);
/// assert_eq!((shape.inputs, shape.parts), (4 * 427, 4));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of equal parts of the inputs. The first layer is applied to each part, with the same
    /// weights; its outputs for all parts are the inputs of the second layer.
    pub parts: usize,
    /// Number of neurons in each hidden layer.
    pub hidden_layers: Vec<usize>,
}

impl Shape {
    /// Returns the shape of a network with the architecture
    /// [`Mlp`](crate::settings::Architecture::Mlp) or
    /// [`SharedEncoder`](crate::settings::Architecture::SharedEncoder).
    pub fn of(settings: &NetworkSettings) -> Shape {
        Shape {
            inputs: input_size(settings.observation_frames),
            parts: match settings.architecture {
                Architecture::SharedEncoder => settings.observation_frames,
                _ => 1,
            },
            hidden_layers: settings.hidden_layers.clone(),
        }
    }

    /// Returns an error if there are several parts but no hidden layer that joins them.
    fn check(&self) -> Result<()> {
        match self.parts > 1 && self.hidden_layers.is_empty() {
            true => Err(candle_core::Error::Msg(NO_FIRST_LAYER.to_owned())),
            false => Ok(()),
        }
    }

    /// Iterates over the shapes of the weights, `[outputs, inputs]`, from the first layer to the
    /// output layer.
    fn weights(&self) -> impl Iterator<Item = [usize; 2]> {
        let mut inputs = self.inputs / self.parts;
        let outputs = self.hidden_layers.iter().copied().chain([Action::COUNT]);
        outputs.enumerate().map(move |(layer, outputs)| {
            let parts = if layer == 0 { self.parts } else { 1 };
            // Checked when the tensors are read: sizes from a file may be arbitrarily large.
            let next = outputs.saturating_mul(parts);
            [outputs, std::mem::replace(&mut inputs, next)]
        })
    }
}

/// A multilayer perceptron with ReLU after each hidden layer and a linear output layer.
///
/// Weights have the shape `[outputs, inputs]` and biases `[outputs]`, as 32-bit floats. In files
/// they are named `layers.0.weight`, `layers.0.bias` and so on, from the input to the output.
///
/// # Examples
///
/// ```
/// use candle_core::{DType, Device, Tensor};
/// use learning::{
///     network::{QNetwork, Shape},
///     settings::Preset,
/// };
/// use task::Random;
///
/// let shape = Shape::of(&Preset::Paper.settings().network);
/// let network = QNetwork::new(&shape, &mut Random::from_key([0; 4]))?;
/// let observations = Tensor::zeros((2, 420), DType::F32, &Device::Cpu)?;
/// assert_eq!(network.forward(&observations)?.dims(), [2, 7]);
/// # Ok::<(), candle_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct QNetwork {
    layers: Vec<Linear>,
    /// See [`Shape::parts`].
    parts: usize,
}

impl QNetwork {
    /// Creates a network with He-normal weights (standard deviation `sqrt(2 / inputs)`) in the
    /// hidden layers, and zeros in the output layer and all biases.
    ///
    /// The paper does not specify the initial weights. With He-normal weights in the output layer,
    /// the best of seven actions starts with a positive value in nearly every state. True values
    /// are never positive, and the value of reaching the exit is exactly 0, so leaving the room
    /// looks worse than staying: the agent avoids the exit until the values of the target network,
    /// which is updated only once per episode, fall below 0. With zero values, there is nothing to
    /// unlearn.
    ///
    /// # Errors
    ///
    /// Returns an error if there are several parts but no hidden layer, or if candle cannot create a
    /// tensor.
    pub fn new(shape: &Shape, random: &mut Random) -> Result<QNetwork> {
        shape.check()?;
        let mut layers = Vec::new();
        for (layer, [outputs, inputs]) in shape.weights().enumerate() {
            let is_output = layer == shape.hidden_layers.len();
            let deviation = if is_output { 0.0 } else { (2.0 / inputs as f32).sqrt() };
            let weight = normal(&[outputs, inputs], deviation, random)?;
            let bias = Tensor::zeros(outputs, DType::F32, &Device::Cpu)?;
            layers.push(Linear::new(weight, Some(bias)));
        }
        Ok(QNetwork { layers, parts: shape.parts })
    }

    /// Creates a network from the weights, `[outputs, inputs]`, and biases, `[outputs]`, of its
    /// layers, in order from the input to the output. The first layer is applied to each of `parts`
    /// parts of the inputs ([`Shape::parts`]).
    ///
    /// # Errors
    ///
    /// Returns the first error in `layers`.
    pub fn from_layers(
        parts: usize,
        layers: impl Iterator<Item = Result<[Tensor; 2]>>,
    ) -> Result<QNetwork> {
        let layers =
            layers.map(|layer| layer.map(|[weight, bias]| Linear::new(weight, Some(bias))));
        Ok(QNetwork { layers: layers.collect::<Result<_>>()?, parts })
    }

    /// Returns the number of parts of the inputs ([`Shape::parts`]).
    pub fn parts(&self) -> usize {
        self.parts
    }

    /// Iterates over the weights and biases of the layers, in order from the input to the output.
    ///
    /// # Panics
    ///
    /// Panics if a layer has no bias, which no constructor allows.
    pub fn layers(&self) -> impl Iterator<Item = (&Tensor, &Tensor)> {
        self.layers
            .iter()
            .map(|layer| (layer.weight(), layer.bias().expect("every layer has a bias")))
    }

    /// Computes the action values, `[batch, 7]`, for observations, `[batch, inputs]`.
    ///
    /// # Errors
    ///
    /// Returns an error if the inputs have the wrong shape.
    ///
    /// # Panics
    ///
    /// Panics if the network has no layers.
    pub fn forward(&self, inputs: &Tensor) -> Result<Tensor> {
        let (last, hidden) = self.layers.split_last().expect("a network has an output layer");
        let (batch, count) = inputs.dims2()?;
        let mut values = inputs.reshape((batch * self.parts, count / self.parts))?;
        for layer in hidden {
            values = layer.forward(&values)?.relu()?;
            // After the first layer, joins the parts of each sample again.
            values = values.reshape((batch, ()))?;
        }
        last.forward(&values)
    }

    /// Iterates over the weights and biases, with the names used in files.
    pub fn tensors(&self) -> impl Iterator<Item = (String, &Tensor)> {
        self.layers().enumerate().flat_map(|(index, (weight, bias))| {
            [(format!("layers.{index}.weight"), weight), (format!("layers.{index}.bias"), bias)]
        })
    }

    /// Returns a network of the same shape with random weights and biases in all layers.
    #[cfg(test)]
    pub(super) fn randomized(&self, seed: u8) -> QNetwork {
        let mut random = Random::from_key([seed.into(); 4]);
        let mut numbers = |tensor: &Tensor| normal(tensor.dims(), 0.1, &mut random);
        QNetwork::from_layers(
            self.parts,
            self.layers().map(|(weight, bias)| Ok([numbers(weight)?, numbers(bias)?])),
        )
        .unwrap()
    }

    /// Creates a network from saved tensors whose names begin with `prefix`.
    ///
    /// Shapes are compared before anything is allocated, so `shape` may come from an untrusted file.
    ///
    /// # Errors
    ///
    /// Returns an error if a tensor is missing, has the wrong shape, or contains an infinite or NaN
    /// value.
    pub fn from_tensors(
        prefix: &str,
        shape: &Shape,
        tensors: &HashMap<String, Tensor>,
    ) -> std::result::Result<QNetwork, WeightsError> {
        shape.check()?;
        let mut layers = Vec::new();
        for (layer, [outputs, inputs]) in shape.weights().enumerate() {
            let tensor = |part: &str, shape: &[usize]| {
                saved(tensors, format!("{prefix}layers.{layer}.{part}"), shape)
            };
            let (weight, bias) =
                (tensor("weight", &[outputs, inputs])?, tensor("bias", &[outputs])?);
            layers.push(Linear::new(weight, Some(bias)));
        }
        Ok(QNetwork { layers, parts: shape.parts })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape() -> Shape {
        Shape { inputs: 420, parts: 1, hidden_layers: vec![64, 128, 64] }
    }

    fn network() -> QNetwork {
        QNetwork::new(&shape(), &mut Random::from_key([7; 4])).unwrap()
    }

    #[test]
    fn tensors_have_the_shapes_of_the_paper() {
        let shapes: Vec<_> =
            network().tensors().map(|(_, tensor)| tensor.dims().to_vec()).collect();
        let expected: [&[usize]; 8] =
            [&[64, 420], &[64], &[128, 64], &[128], &[64, 128], &[64], &[7, 64], &[7]];
        assert_eq!(shapes, expected);
    }

    #[test]
    fn initial_weights_are_he_normal_in_hidden_layers_and_zero_elsewhere() {
        for (name, tensor) in network().tensors() {
            let numbers: Vec<f32> = tensor.flatten_all().unwrap().to_vec1().unwrap();
            if name.ends_with("bias") || name.starts_with("layers.3") {
                assert!(numbers.iter().all(|number| *number == 0.0));
            } else {
                let squares: f32 = numbers.iter().map(|number| number * number).sum();
                let deviation = (squares / numbers.len() as f32).sqrt();
                let expected = (2.0 / tensor.dims()[1] as f32).sqrt();
                assert!(
                    (deviation / expected - 1.0).abs() < 0.12,
                    "{name}: {deviation}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn rejects_tensors_of_another_network() {
        let network = network();
        let mut tensors: HashMap<String, Tensor> = network
            .tensors()
            .map(|(name, tensor)| (name.to_owned(), tensor.copy().unwrap()))
            .collect();
        let read = |tensors: &_| QNetwork::from_tensors("", &shape(), tensors);
        read(&tensors).unwrap();
        for invalid in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let bias = [0.0, 0.0, 0.0, invalid, 0.0, 0.0, 0.0];
            let bias = Tensor::new(&bias, &Device::Cpu).unwrap();
            tensors.insert("layers.3.bias".into(), bias);
            assert!(matches!(read(&tensors), Err(WeightsError::NotFinite(_))));
        }
        tensors.insert("layers.3.bias".into(), Tensor::zeros(8, DType::F32, &Device::Cpu).unwrap());
        assert!(matches!(read(&tensors), Err(WeightsError::Shape { .. })));
        tensors.remove("layers.3.bias");
        assert!(matches!(read(&tensors), Err(WeightsError::Missing(_))));
        // A shape that is too large to allocate.
        let huge = Shape { parts: 4, hidden_layers: vec![usize::MAX / 1024; 3], ..shape() };
        let result = QNetwork::from_tensors("", &huge, &tensors);
        assert!(matches!(result, Err(WeightsError::Shape { .. })));
    }
}
