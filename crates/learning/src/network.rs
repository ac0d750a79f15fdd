//! The deep Q-network: a multilayer perceptron from an observation to the values of the seven actions.
//!
//! Here it is described, initialised, named for files and, in tests, computed by candle;
//! [`super::perceptron`] computes it in the loop.

use std::collections::HashMap;

use candle_core::{DType, Device, Module, Result, Tensor};
use candle_nn::Linear;
use task::{Action, Random};
use thiserror::Error;

/// A multilayer perceptron with ReLU between its layers, and none behind the last.
///
/// Weights are `[outputs, inputs]` and biases `[outputs]`, 32-bit floats; in files they are
/// `layers.0.weight`, `layers.0.bias` and so on, from the input.
#[derive(Clone, Debug)]
pub struct QNetwork {
    layers: Vec<Linear>,
}

/// Why saved tensors are not this network's.
#[derive(Debug, Error)]
pub enum WeightsError {
    /// A tensor is not there.
    #[error("there is no tensor '{0}'")]
    Missing(String),
    /// A tensor belongs to a network of another form.
    #[error("the tensor '{name}' is {found:?}: expected {expected:?}, as config.yaml describes it")]
    Shape {
        /// The tensor.
        name: String,
        /// Its shape.
        found: Vec<usize>,
        /// The shape of this network's.
        expected: Vec<usize>,
    },
    /// A number is infinite or not a number.
    #[error("the tensor '{0}' holds a number that is not finite")]
    NotFinite(String),
    /// candle's arithmetic or conversion failed.
    #[error(transparent)]
    Candle(#[from] candle_core::Error),
}

impl QNetwork {
    /// A network with He-normal weights, deviation `sqrt(2 / inputs)`, before each ReLU; weights of
    /// zero in the output layer, and biases of zero.
    ///
    /// The paper says nothing of initial weights. Behind the last layer there is no ReLU, and with
    /// He-normal weights there the best of seven actions starts with a positive value in nearly every
    /// state. True values are never positive, and that of leaving the room is exactly 0, which then
    /// looks worse than staying: the agent avoids the exit until the target network, which moves once
    /// an episode, has sunk below 0. From values of zero, nothing has to be unlearnt first.
    pub fn new(inputs: usize, hidden_layers: &[usize], random: &mut Random) -> Result<QNetwork> {
        let mut layers = Vec::new();
        let mut inputs = inputs;
        let sizes = hidden_layers.iter().copied().chain([Action::COUNT]);
        for (layer, outputs) in sizes.enumerate() {
            let is_output = layer == hidden_layers.len();
            let deviation = if is_output { 0.0 } else { (2.0 / inputs as f32).sqrt() };
            let weights: Vec<f32> =
                (0..inputs * outputs).map(|_| deviation * truncated_normal(random)).collect();
            let weight = Tensor::from_vec(weights, (outputs, inputs), &Device::Cpu)?;
            let bias = Tensor::zeros(outputs, DType::F32, &Device::Cpu)?;
            layers.push(Linear::new(weight, Some(bias)));
            inputs = outputs;
        }
        Ok(QNetwork { layers })
    }

    /// A network of these weights `[outputs, inputs]` and biases `[outputs]`.
    pub fn from_layers(layers: impl Iterator<Item = Result<[Tensor; 2]>>) -> Result<QNetwork> {
        let layers =
            layers.map(|layer| layer.map(|[weight, bias]| Linear::new(weight, Some(bias))));
        Ok(QNetwork { layers: layers.collect::<Result<_>>()? })
    }

    /// The weights and biases, from the input.
    pub fn layers(&self) -> impl Iterator<Item = (&Tensor, &Tensor)> {
        self.layers
            .iter()
            .map(|layer| (layer.weight(), layer.bias().expect("every layer is made with a bias")))
    }

    /// The values of the actions: `[batch, inputs]` to `[batch, 7]`.
    pub fn forward(&self, inputs: &Tensor) -> Result<Tensor> {
        let (last, hidden) = self.layers.split_last().expect("the output layer always exists");
        let mut values = inputs.clone();
        for layer in hidden {
            values = layer.forward(&values)?.relu()?;
        }
        last.forward(&values)
    }

    /// The weights and biases with their names.
    pub fn tensors(&self) -> impl Iterator<Item = (String, &Tensor)> {
        self.layers().enumerate().flat_map(|(index, (weight, bias))| {
            [(format!("layers.{index}.weight"), weight), (format!("layers.{index}.bias"), bias)]
        })
    }

    /// A network of the same shape, the output layer too filled with numbers.
    #[cfg(test)]
    pub(super) fn randomized(&self, seed: u8) -> QNetwork {
        let mut random = Random::from_key([seed.into(); 4]);
        let mut numbers = |tensor: &Tensor| {
            let count = tensor.elem_count();
            let values: Vec<f32> =
                (0..count).map(|_| 0.1 * truncated_normal(&mut random)).collect();
            Tensor::from_vec(values, tensor.dims(), &Device::Cpu)
        };
        QNetwork::from_layers(
            self.layers().map(|(weight, bias)| Ok([numbers(weight)?, numbers(bias)?])),
        )
        .unwrap()
    }

    /// A network of saved weights and biases, if they are of this form. It takes no more memory than
    /// they do, whatever the form is.
    pub fn from_tensors(
        prefix: &str,
        inputs: usize,
        hidden_layers: &[usize],
        tensors: &HashMap<String, Tensor>,
    ) -> std::result::Result<QNetwork, WeightsError> {
        let mut layers = Vec::new();
        let mut inputs = inputs;
        let sizes = hidden_layers.iter().copied().chain([Action::COUNT]);
        for (layer, outputs) in sizes.enumerate() {
            let of = |part: &str, shape: &[usize]| {
                saved(tensors, format!("{prefix}layers.{layer}.{part}"), shape)
            };
            let (weight, bias) = (of("weight", &[outputs, inputs])?, of("bias", &[outputs])?);
            layers.push(Linear::new(weight, Some(bias)));
            inputs = outputs;
        }
        Ok(QNetwork { layers })
    }
}

/// A saved tensor, if it is of this shape and its numbers are finite.
fn saved(
    tensors: &HashMap<String, Tensor>,
    name: String,
    expected: &[usize],
) -> std::result::Result<Tensor, WeightsError> {
    let Some(tensor) = tensors.get(&name) else {
        return Err(WeightsError::Missing(name));
    };
    if tensor.dims() != expected {
        let (found, expected) = (tensor.dims().to_vec(), expected.to_vec());
        return Err(WeightsError::Shape { name, found, expected });
    }
    let tensor = tensor.to_dtype(DType::F32)?;
    let numbers: Vec<f32> = tensor.flatten_all()?.to_vec1()?;
    match numbers.iter().all(|number| number.is_finite()) {
        true => Ok(tensor),
        false => Err(WeightsError::NotFinite(name)),
    }
}

/// A normal number within two deviations, scaled to a deviation of 1: what TensorFlow, which the
/// paper uses, takes for He-normal weights.
fn truncated_normal(random: &mut Random) -> f32 {
    /// The deviation of a standard normal distribution that is cut off at -2 and 2.
    const DEVIATION: f32 = 0.879_625_7;
    loop {
        let number = random.normal(1.0) as f32;
        if number.abs() <= 2.0 {
            return number / DEVIATION;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network() -> QNetwork {
        QNetwork::new(420, &[64, 128, 64], &mut Random::from_key([7; 4])).unwrap()
    }

    #[test]
    fn the_shape_is_the_papers() {
        let shapes: Vec<_> =
            network().tensors().map(|(_, tensor)| tensor.dims().to_vec()).collect();
        let expected: [&[usize]; 8] =
            [&[64, 420], &[64], &[128, 64], &[128], &[64, 128], &[64], &[7, 64], &[7]];
        assert_eq!(shapes, expected);
    }

    #[test]
    fn initial_weights_are_he_normal_before_each_relu_and_zero_elsewhere() {
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
                    "{name}: {deviation} {expected}"
                );
            }
        }
    }

    #[test]
    fn foreign_tensors_are_refused() {
        let network = network();
        let mut tensors: HashMap<String, Tensor> = network
            .tensors()
            .map(|(name, tensor)| (name.to_owned(), tensor.copy().unwrap()))
            .collect();
        let read = |tensors: &_| QNetwork::from_tensors("", 420, &[64, 128, 64], tensors);
        read(&tensors).unwrap();
        for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let bias = Tensor::new(&[0.0, 0.0, 0.0, wrong, 0.0, 0.0, 0.0], &Device::Cpu).unwrap();
            tensors.insert("layers.3.bias".into(), bias);
            assert!(matches!(read(&tensors), Err(WeightsError::NotFinite(_))));
        }
        tensors.insert("layers.3.bias".into(), Tensor::zeros(8, DType::F32, &Device::Cpu).unwrap());
        assert!(matches!(read(&tensors), Err(WeightsError::Shape { .. })));
        tensors.remove("layers.3.bias");
        assert!(matches!(read(&tensors), Err(WeightsError::Missing(_))));
        // A form that would take more memory than there is.
        let huge = vec![usize::MAX / 1024; 3];
        let result = QNetwork::from_tensors("", 420, &huge, &tensors);
        assert!(matches!(result, Err(WeightsError::Shape { .. })));
    }
}
