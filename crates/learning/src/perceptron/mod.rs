//! The backend for multilayer perceptrons: SIMD kernels for the forward pass, backpropagation and
//! Adam.
//!
//! [`network`](crate::network) initializes the weights and names them in files; this module stores
//! them in the order in which the kernels read them. The kernels do not allocate. They use the
//! widest vector instructions that the processor supports, selected at run time, and give the same
//! result with any instruction set.

mod adam;
mod kernels;
mod layer;
mod tile;

use std::collections::HashMap;

use candle_core::Tensor;
pub use pulp::Arch;

pub use self::kernels::Kernels;
use self::{
    layer::{Finish, Layer, Product},
    tile::compute,
};
use super::{activations::Activations, backend::Network, network::QNetwork, weights::WeightsError};

/// A multilayer perceptron with ReLU after each hidden layer and a linear output layer.
///
/// # Examples
///
/// ```
/// use learning::{backend::Network, network::QNetwork, perceptron::Perceptron};
/// use task::Random;
///
/// let network = QNetwork::new(420, &[64, 128, 64], &mut Random::from_key([0; 4]))?;
/// let perceptron = Perceptron::new(&network)?;
/// let mut activations = perceptron.activations(2);
/// activations.inputs_mut().for_each(|input| input.fill(0.5));
/// perceptron.forward(&mut activations);
/// // The weights of the output layer start at zero.
/// assert!(activations.outputs().all(|values| values[..7] == [0.0; 7]));
/// # Ok::<(), candle_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Perceptron {
    layers: Vec<Layer>,
    arch: Arch,
}

/// Iterates over instruction sets that this processor supports: the widest vector instructions,
/// then AVX2 (if supported), then no vector instructions. All of them give the same results to the
/// last bit.
pub fn arches() -> impl Iterator<Item = Arch> {
    #[cfg(target_arch = "x86_64")]
    let narrower = pulp::x86::V3::try_new().map(Arch::V3);
    #[cfg(not(target_arch = "x86_64"))]
    let narrower = None;
    [Arch::new()].into_iter().chain(narrower).chain([Arch::Scalar])
}

impl Perceptron {
    /// Creates a perceptron with the weights of `network`.
    ///
    /// # Errors
    ///
    /// Returns an error if candle cannot convert the weights.
    pub fn new(network: &QNetwork) -> candle_core::Result<Perceptron> {
        let layers = network.layers().map(|(weight, _)| {
            let (outputs, inputs) = weight.dims2()?;
            Ok(Layer::zeros(inputs, outputs))
        });
        let layers = layers.collect::<candle_core::Result<_>>()?;
        let mut perceptron = Perceptron { layers, arch: Arch::new() };
        perceptron.copy_from(network)?;
        Ok(perceptron)
    }

    /// Copies the weights of a network of the same shape.
    ///
    /// # Errors
    ///
    /// Returns an error if candle cannot convert the weights.
    ///
    /// # Panics
    ///
    /// May panic if `network` has a different shape.
    pub fn copy_from(&mut self, network: &QNetwork) -> candle_core::Result<()> {
        for (layer, (weight, bias)) in self.layers.iter_mut().zip(network.layers()) {
            layer.read(weight, bias)?;
        }
        Ok(())
    }

    /// Returns a [`QNetwork`] with the weights of this perceptron.
    ///
    /// # Errors
    ///
    /// Returns an error if candle cannot create a tensor.
    pub fn network(&self) -> candle_core::Result<QNetwork> {
        QNetwork::from_layers(self.layers.iter().map(Layer::tensors))
    }

    /// Returns a perceptron of the same shape, filled with zeros.
    pub fn zeros_like(&self) -> Perceptron {
        let zeros = |layer: &Layer| Layer::zeros(layer.inputs, layer.outputs);
        Perceptron { layers: self.layers.iter().map(zeros).collect(), arch: self.arch }
    }

    /// Moves the weights towards those of another perceptron by the fraction `tau`, 0 to 1 (eq. 6).
    pub fn move_towards(&mut self, other: &Perceptron, tau: f32) {
        for (layer, other) in self.layers.iter_mut().zip(&other.layers) {
            for (to, from) in layer.parameters.iter_mut().zip(other.parameters.iter()) {
                *to += tau * (from - *to);
            }
        }
    }
}

impl Network for Perceptron {
    fn activations(&self, batch: usize) -> Activations {
        let input_count = self.layers.first().map_or(0, |layer| layer.inputs);
        Activations::new(batch, input_count, self.layers.iter().map(Layer::width), self.arch)
    }

    fn forward(&self, activations: &mut Activations) {
        let rows = activations.batch();
        let Activations { inputs, outputs, .. } = activations;
        for (index, layer) in self.layers.iter().enumerate() {
            let (before, after) = outputs.split_at_mut(index);
            let (left, left_stride) = match before.last() {
                None => (&*inputs, layer.inputs),
                Some(output) => (output, layer.input_width()),
            };
            let (weights, bias) = layer.parameters.split_at(layer.inputs * layer.width());
            let is_last = index + 1 == self.layers.len();
            let product = Product {
                left,
                left_stride,
                rows,
                right: weights,
                terms: layer.inputs,
                bias: Some(bias),
                product: &mut after[0],
                width: layer.width(),
                finish: if is_last { Finish::Linear } else { Finish::Relu },
            };
            compute(self.arch, product);
        }
    }

    fn tensors(&self) -> candle_core::Result<Vec<(String, Tensor)>> {
        let network = self.network()?;
        Ok(network.tensors().map(|(name, tensor)| (name, tensor.clone())).collect())
    }

    fn read(
        &mut self,
        prefix: &str,
        tensors: &HashMap<String, Tensor>,
    ) -> Result<(), WeightsError> {
        let inputs = self.layers.first().map_or(0, |layer| layer.inputs);
        let (_, hidden) = self.layers.split_last().expect("a network has an output layer");
        let hidden: Vec<usize> = hidden.iter().map(|layer| layer.outputs).collect();
        Ok(self.copy_from(&QNetwork::from_tensors(prefix, inputs, &hidden, tensors)?)?)
    }

    fn set_arch(&mut self, arch: Arch) {
        self.arch = arch;
    }

    fn clone_box(&self) -> Box<dyn Network> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests;
