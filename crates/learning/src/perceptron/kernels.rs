//! The backend for multilayer perceptrons, with or without a shared first layer: the architectures of
//! both presets.

use candle_core::Result;

use super::{Arch, Perceptron, adam::Adam};
use crate::{
    activations::Activations,
    backend::{Backend, Network, PREFIXES},
    network::QNetwork,
    settings::OptimizerSettings,
};

/// A training perceptron, its optimizer, and the target perceptron.
#[derive(Clone, Debug)]
pub struct Kernels {
    train: Perceptron,
    target: Perceptron,
    adam: Adam,
}

impl Kernels {
    /// Creates a backend for batches of `batch` samples. Both networks start with the weights of
    /// `network`.
    ///
    /// # Errors
    ///
    /// Returns an error if candle cannot convert the weights.
    pub fn new(network: &QNetwork, batch: usize, settings: &OptimizerSettings) -> Result<Kernels> {
        let train = Perceptron::new(network)?;
        Ok(Kernels { adam: Adam::new(&train, batch, settings), target: train.clone(), train })
    }
}

impl Backend for Kernels {
    fn train(&self) -> &dyn Network {
        &self.train
    }

    fn target(&self) -> &dyn Network {
        &self.target
    }

    fn output_gradient(&mut self) -> &mut [f32] {
        self.adam.output_gradient()
    }

    fn update(&mut self, activations: &Activations) {
        self.adam.update(&mut self.train, activations);
    }

    fn update_target(&mut self, tau: f32) {
        self.target.move_towards(&self.train, tau);
    }

    fn set_learning_rate(&mut self, learning_rate: f64) {
        self.adam.learning_rate = learning_rate;
    }

    fn updates(&self) -> u64 {
        self.adam.step
    }

    fn set_updates(&mut self, updates: u64) {
        self.adam.step = updates;
    }

    fn networks(&self) -> [(&'static str, &dyn Network); 4] {
        let Kernels { train, target, adam: Adam { first, second, .. } } = self;
        let [a, b, c, d] = PREFIXES;
        [(a, train), (b, target), (c, first), (d, second)]
    }

    fn networks_mut(&mut self) -> [(&'static str, &mut dyn Network); 4] {
        let Kernels { train, target, adam: Adam { first, second, .. } } = self;
        let [a, b, c, d] = PREFIXES;
        [(a, train), (b, target), (c, first), (d, second)]
    }

    fn set_arch(&mut self, arch: Arch) {
        self.train.set_arch(arch);
        self.target.set_arch(arch);
    }

    fn clone_box(&self) -> Box<dyn Backend> {
        Box::new(self.clone())
    }
}
