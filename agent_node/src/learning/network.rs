//! The deep Q-network: a multilayer perceptron from an image to the values of the seven actions.

use std::collections::HashMap;

use candle_core::{DType, Device, Module, Result, Tensor, Var};
use candle_nn::Linear;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use thiserror::Error;

use super::{action::Action, adam::TowardsTraining, image::Image};

/// A multilayer perceptron with ReLU between its layers, and none behind the last.
///
/// Weights are `[outputs, inputs]` and biases `[outputs]`, 32-bit floats; in files they are
/// `layers.0.weight`, `layers.0.bias` and so on, from the input.
#[derive(Clone, Debug)]
pub struct QNetwork {
    variables: Vec<(String, Var)>,
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
    pub fn new(hidden_layers: &[usize], random: &mut impl Rng) -> Result<QNetwork> {
        let mut variables = Vec::new();
        let mut inputs = Image::BYTES;
        let sizes = hidden_layers.iter().copied().chain([Action::COUNT]);
        for (layer, outputs) in sizes.enumerate() {
            let is_output = layer == hidden_layers.len();
            let deviation = if is_output { 0.0 } else { (2.0 / inputs as f32).sqrt() };
            let weights: Vec<f32> =
                (0..inputs * outputs).map(|_| deviation * truncated_normal(random)).collect();
            let weight = Var::from_vec(weights, (outputs, inputs), &Device::Cpu)?;
            let bias = Var::zeros(outputs, DType::F32, &Device::Cpu)?;
            variables.push((format!("layers.{layer}.weight"), weight));
            variables.push((format!("layers.{layer}.bias"), bias));
            inputs = outputs;
        }
        Ok(QNetwork::from_variables(variables))
    }

    fn from_variables(variables: Vec<(String, Var)>) -> QNetwork {
        let layers = variables
            .chunks_exact(2)
            .map(|pair| {
                Linear::new(pair[0].1.as_tensor().clone(), Some(pair[1].1.as_tensor().clone()))
            })
            .collect();
        QNetwork { variables, layers }
    }

    /// Another network with the same weights, which does not follow this one's.
    pub fn copied(&self) -> Result<QNetwork> {
        let copy =
            |(name, var): &(String, Var)| Ok((name.clone(), Var::from_tensor(&var.copy()?)?));
        let variables = self.variables.iter().map(copy).collect::<Result<_>>()?;
        Ok(QNetwork::from_variables(variables))
    }

    /// The values of the actions: `[batch, 420]` to `[batch, 7]`.
    pub fn forward(&self, inputs: &Tensor) -> Result<Tensor> {
        let (last, hidden) = self.layers.split_last().expect("the output layer always exists");
        let mut values = inputs.clone();
        for layer in hidden {
            values = layer.forward(&values)?.relu()?;
        }
        last.forward(&values)
    }

    /// The values of the seven actions in one state.
    pub fn values(&self, image: &Image) -> Result<[f32; Action::COUNT]> {
        let mut input = vec![0.0; Image::BYTES];
        Image::write_input(image.bytes(), &mut input);
        let output = self.forward(&Tensor::from_vec(input, (1, Image::BYTES), &Device::Cpu)?)?;
        let values = output.flatten_all()?.to_vec1()?;
        Ok(values.try_into().expect("the output layer has one neuron per action"))
    }

    /// Moves the weights by `tau` of the way towards another network's (eq. 6).
    pub fn move_towards(&self, train: &QNetwork, tau: f32) -> Result<()> {
        for ((_, target), (_, train)) in self.variables.iter().zip(&train.variables) {
            target.inplace_op2(train, &TowardsTraining { tau })?;
        }
        Ok(())
    }

    /// The variables, for an optimizer.
    pub fn variables(&self) -> Vec<Var> {
        self.variables.iter().map(|(_, variable)| variable.clone()).collect()
    }

    /// The weights and biases with their names.
    pub fn tensors(&self) -> impl Iterator<Item = (&str, &Tensor)> {
        self.variables.iter().map(|(name, variable)| (name.as_str(), variable.as_tensor()))
    }

    /// Fills the network with numbers, the output layer too.
    #[cfg(test)]
    pub(super) fn randomize(&self, seed: u8) {
        let mut random = <rand_chacha::ChaCha8Rng as rand::SeedableRng>::from_seed([seed; 32]);
        for (_, variable) in &self.variables {
            let count = variable.elem_count();
            let values: Vec<f32> =
                (0..count).map(|_| 0.1 * truncated_normal(&mut random)).collect();
            let tensor = Tensor::from_vec(values, variable.dims(), &Device::Cpu).unwrap();
            variable.set(&tensor).unwrap();
        }
    }

    /// Takes over weights and biases; changes nothing unless all of them fit.
    pub fn set_tensors(
        &self,
        prefix: &str,
        tensors: &HashMap<String, Tensor>,
    ) -> std::result::Result<(), WeightsError> {
        let mut found = Vec::new();
        for (name, variable) in &self.variables {
            let name = format!("{prefix}{name}");
            let tensor = tensors.get(&name).ok_or_else(|| WeightsError::Missing(name.clone()))?;
            if tensor.dims() != variable.dims() {
                let (found, expected) = (tensor.dims().to_vec(), variable.dims().to_vec());
                return Err(WeightsError::Shape { name, found, expected });
            }
            let tensor = tensor.to_dtype(DType::F32)?;
            let numbers: Vec<f32> = tensor.flatten_all()?.to_vec1()?;
            if !numbers.iter().all(|number| number.is_finite()) {
                return Err(WeightsError::NotFinite(name));
            }
            found.push((variable, tensor));
        }
        for (variable, tensor) in found {
            variable.set(&tensor)?;
        }
        Ok(())
    }
}

/// A normal number within two deviations, scaled to a deviation of 1: what TensorFlow, which the
/// paper uses, takes for He-normal weights.
fn truncated_normal(random: &mut impl Rng) -> f32 {
    /// The deviation of a standard normal distribution that is cut off at -2 and 2.
    const DEVIATION: f32 = 0.879_625_7;
    loop {
        let number: f32 = StandardNormal.sample(random);
        if number.abs() <= 2.0 {
            return number / DEVIATION;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn network() -> QNetwork {
        QNetwork::new(&[64, 128, 64], &mut ChaCha8Rng::from_seed([7; 32])).unwrap()
    }

    fn random_network(seed: u8) -> QNetwork {
        let network = network();
        network.randomize(seed);
        network
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
    fn a_small_network_by_hand() {
        let network = network();
        for (_, variable) in &network.variables {
            variable.set(&variable.zeros_like().unwrap()).unwrap();
        }
        // One path: pixel 3 -> neuron 5 -> neuron 6 -> neuron 7 -> action 2, and a negative one
        // into neuron 8, which ReLU cuts off.
        let set = |layer: usize, row: usize, column: usize, value: f32| {
            let weight = &network.variables[2 * layer].1;
            let mut rows: Vec<Vec<f32>> = weight.to_vec2().unwrap();
            rows[row][column] = value;
            weight.set(&Tensor::new(rows, &Device::Cpu).unwrap()).unwrap();
        };
        set(0, 5, 3, 2.0);
        set(0, 8, 3, -2.0);
        set(1, 6, 5, 3.0);
        set(1, 6, 8, 100.0);
        set(2, 7, 6, 0.5);
        set(3, 2, 7, -1.0);
        let mut bytes = [0; Image::BYTES];
        bytes[3] = 51;
        let values = network.values(&Image::try_from(bytes.as_slice()).unwrap()).unwrap();
        // 51 / 255 = 0.2; 0.2 * 2 * 3 * 0.5 * -1 = -0.6
        assert!((values[2] + 0.6).abs() < 1e-6);
        assert!(values.iter().enumerate().all(|(i, v)| i == 2 || *v == 0.0));
    }

    #[test]
    fn the_target_moves_by_tau() {
        let (train, target) = (random_network(1), random_network(2));
        let before: Vec<f32> = target.variables[0].1.flatten_all().unwrap().to_vec1().unwrap();
        target.move_towards(&train, 0.1).unwrap();
        let after: Vec<f32> = target.variables[0].1.flatten_all().unwrap().to_vec1().unwrap();
        let train: Vec<f32> = train.variables[0].1.flatten_all().unwrap().to_vec1().unwrap();
        for ((before, after), train) in before.iter().zip(after).zip(train) {
            assert!((after - (0.9 * before + 0.1 * train)).abs() < 1e-6);
        }
    }

    #[test]
    fn a_copy_is_equal_and_its_own() {
        let (original, image) =
            (random_network(1), Image::try_from([9; Image::BYTES].as_slice()).unwrap());
        let copy = original.copied().unwrap();
        let values = original.values(&image).unwrap();
        assert_eq!(copy.values(&image).unwrap(), values);
        copy.move_towards(&random_network(2), 0.5).unwrap();
        assert_eq!(original.values(&image).unwrap(), values);
        assert_ne!(copy.values(&image).unwrap(), values);
    }

    #[test]
    fn foreign_tensors_are_refused() {
        let network = network();
        let mut tensors: HashMap<String, Tensor> = network
            .tensors()
            .map(|(name, tensor)| (name.to_owned(), tensor.copy().unwrap()))
            .collect();
        network.set_tensors("", &tensors).unwrap();
        let nan = Tensor::new(&[f32::NAN; 7], &Device::Cpu).unwrap();
        tensors.insert("layers.3.bias".into(), nan);
        assert!(matches!(network.set_tensors("", &tensors), Err(WeightsError::NotFinite(_))));
        tensors.insert("layers.3.bias".into(), Tensor::zeros(8, DType::F32, &Device::Cpu).unwrap());
        assert!(matches!(network.set_tensors("", &tensors), Err(WeightsError::Shape { .. })));
        tensors.remove("layers.3.bias");
        assert!(matches!(network.set_tensors("", &tensors), Err(WeightsError::Missing(_))));
    }
}
