//! The arithmetic of the Q-network, at the speed of the processor.
//!
//! [`super::network`] describes a network; here its weights lie as the hot loop reads them, and
//! forward pass, backward propagation and Adam are a few passes over them, without allocation.
//! Vector instructions are chosen at run time, by what the processor has.

mod adam;
mod layer;
mod tile;

use std::slice::ChunksExactMut;

pub use pulp::Arch;
use pulp::NullaryFnOnce;

pub use self::adam::Adam;
use self::{
    layer::{Finish, Floats, Layer, Product, zeros},
    tile::compute,
};
use super::{
    network::QNetwork,
    observation::{Moment, View, input_size, write_input},
};

/// A multilayer perceptron with ReLU between its layers, and none behind the last.
#[derive(Clone, Debug)]
pub struct Perceptron {
    layers: Vec<Layer>,
    arch: Arch,
}

/// A forward pass: the inputs of a batch and the outputs of every layer.
#[derive(Clone, Debug)]
pub struct Activations {
    /// `[batch, inputs]`
    inputs: Floats,
    /// `[batch, width]` for each layer
    outputs: Vec<Floats>,
    input_count: usize,
    output_width: usize,
    batch: usize,
    arch: Arch,
}

/// This processor's widest vectors, and those of processors that have less: AVX2 and none at all. By all
/// of them the same numbers come out, to the last bit.
pub fn arches() -> impl Iterator<Item = Arch> {
    #[cfg(target_arch = "x86_64")]
    let narrower = pulp::x86::V3::try_new().map(Arch::V3);
    #[cfg(not(target_arch = "x86_64"))]
    let narrower = None;
    [Arch::new()].into_iter().chain(narrower).chain([Arch::Scalar])
}

impl Perceptron {
    /// Computes by these vector instructions from now on.
    pub(crate) fn set_arch(&mut self, arch: Arch) {
        self.arch = arch;
    }

    /// A network with the weights of another.
    pub fn new(network: &QNetwork) -> candle_core::Result<Perceptron> {
        let layers = network.layers().map(|(weight, _)| {
            let (outputs, inputs) = weight.dims2()?;
            Ok(Layer::zeros(inputs, outputs))
        });
        let layers = layers.collect::<candle_core::Result<_>>()?;
        let mut perceptron = Perceptron { layers, arch: Arch::new() };
        perceptron.read(network)?;
        Ok(perceptron)
    }

    /// Takes over the weights of a network of the same shape.
    pub fn read(&mut self, network: &QNetwork) -> candle_core::Result<()> {
        for (layer, (weight, bias)) in self.layers.iter_mut().zip(network.layers()) {
            layer.read(weight, bias)?;
        }
        Ok(())
    }

    /// The network that has these weights.
    pub fn network(&self) -> candle_core::Result<QNetwork> {
        QNetwork::from_layers(self.layers.iter().map(Layer::tensors))
    }

    /// A network of the same shape, all zero.
    pub fn zeros_like(&self) -> Perceptron {
        let zeros = |layer: &Layer| Layer::zeros(layer.inputs, layer.outputs);
        Perceptron { layers: self.layers.iter().map(zeros).collect(), arch: self.arch }
    }

    /// Room for a forward pass of so many samples.
    pub fn activations(&self, batch: usize) -> Activations {
        let input_count = self.layers.first().map_or(0, |layer| layer.inputs);
        Activations {
            inputs: zeros(batch * input_count),
            outputs: self.layers.iter().map(|layer| zeros(batch * layer.width())).collect(),
            input_count,
            output_width: self.layers.last().map_or(0, Layer::width),
            batch,
            arch: self.arch,
        }
    }

    /// The outputs for the inputs.
    pub fn forward(&self, activations: &mut Activations) {
        let Activations { inputs, outputs, batch, .. } = activations;
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
                rows: *batch,
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

    /// Moves the weights by `tau` of the way towards another network's (eq. 6).
    pub fn move_towards(&mut self, other: &Perceptron, tau: f32) {
        for (layer, other) in self.layers.iter_mut().zip(&other.layers) {
            for (to, from) in layer.parameters.iter_mut().zip(other.parameters.iter()) {
                *to += tau * (from - *to);
            }
        }
    }
}

impl Activations {
    /// Computes by these vector instructions from now on.
    pub(crate) fn set_arch(&mut self, arch: Arch) {
        self.arch = arch;
    }

    /// The inputs of each sample.
    pub fn inputs_mut(&mut self) -> impl Iterator<Item = &mut [f32]> {
        self.inputs.chunks_exact_mut(self.input_count)
    }

    /// Takes observations of so many images for inputs, one for each sample: the present moment and
    /// those before it, and how to look at them.
    pub fn read_observations<'a, Past>(
        &mut self,
        frames: usize,
        observations: impl Iterator<Item = (Past, View)>,
    ) where
        Past: Iterator<Item = Moment<'a>>,
    {
        debug_assert_eq!(self.input_count, input_size(frames));
        let inputs = self.inputs.chunks_exact_mut(self.input_count);
        self.arch.dispatch(ReadObservations { frames, inputs, observations });
    }

    /// The outputs for each sample, behind them padding.
    pub fn outputs(&self) -> impl Iterator<Item = &[f32]> {
        self.outputs.last().into_iter().flat_map(|last| last.chunks_exact(self.output_width))
    }

    /// Outputs of a sample with padding: how far the next sample's are behind them.
    pub fn output_width(&self) -> usize {
        self.output_width
    }
}

/// Not a closure, which the compiler might leave outside of what it makes for the processor.
struct ReadObservations<'a, Observations> {
    frames: usize,
    inputs: ChunksExactMut<'a, f32>,
    observations: Observations,
}

impl<'a, Past, Observations> NullaryFnOnce for ReadObservations<'_, Observations>
where
    Past: Iterator<Item = Moment<'a>>,
    Observations: Iterator<Item = (Past, View)>,
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (input, (past, view)) in self.inputs.zip(self.observations) {
            write_input(past, self.frames, view, input);
        }
    }
}

#[cfg(test)]
mod tests;
