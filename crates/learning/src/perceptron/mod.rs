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
use super::{
    activations::Activations,
    backend::Network,
    network::{QNetwork, Shape},
    weights::WeightsError,
};

/// A multilayer perceptron with ReLU after each hidden layer and a linear output layer.
///
/// # Examples
///
/// ```
/// use learning::{
///     backend::Network,
///     network::{QNetwork, Shape},
///     perceptron::Perceptron,
///     settings::Preset,
/// };
/// use task::Random;
///
/// let shape = Shape::of(&Preset::Paper.settings().network);
/// let network = QNetwork::new(&shape, &mut Random::from_key([0; 4]))?;
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
        let mut layers = Vec::new();
        for (index, (weight, _)) in network.layers().enumerate() {
            let (outputs, inputs) = weight.dims2()?;
            let parts = if index == 0 { network.parts() } else { 1 };
            let groups = if index == 1 { network.parts() } else { 1 };
            layers.push(Layer::zeros(groups, inputs / groups, outputs, parts));
        }
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
        QNetwork::from_layers(self.parts(), self.layers.iter().map(Layer::tensors))
    }

    /// Returns a perceptron of the same shape, filled with zeros.
    pub fn zeros_like(&self) -> Perceptron {
        Perceptron { layers: self.layers.iter().map(Layer::zeros_like).collect(), arch: self.arch }
    }

    /// Returns the number of parts of a sample to which the first layer is applied.
    fn parts(&self) -> usize {
        self.layers.first().map_or(1, |layer| layer.parts)
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
        let input_count = self.layers.first().map_or(0, |layer| layer.parts * layer.inputs);
        let widths = self.layers.iter().map(|layer| layer.parts * layer.width());
        Activations::new(batch, input_count, widths, self.arch)
    }

    fn forward(&self, activations: &mut Activations) {
        let batch = activations.batch();
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
                rows: batch * layer.parts,
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
        let (_, hidden) = self.layers.split_last().expect("a network has an output layer");
        let shape = Shape {
            inputs: self.layers[0].inputs * self.parts(),
            parts: self.parts(),
            hidden_layers: hidden.iter().map(|layer| layer.outputs).collect(),
        };
        Ok(self.copy_from(&QNetwork::from_tensors(prefix, &shape, tensors)?)?)
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
