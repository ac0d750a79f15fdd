//! The interface between the learner and the implementation of its networks.
//!
//! There are two implementations: [`perceptron`](crate::perceptron) provides kernels for multilayer
//! perceptrons, and [`autograd`](crate::autograd) uses candle's tensors for all other
//! architectures. [`architectures`](crate::architectures) selects the implementation.

use std::{collections::HashMap, fmt::Debug};

use candle_core::{Result, Tensor};
use pulp::Arch;

use crate::{activations::Activations, weights::WeightsError};

/// A Q-network: maps observations to action values.
pub trait Network: Debug + Send + Sync {
    /// Returns buffers for a forward pass over `batch` observations.
    fn activations(&self, batch: usize) -> Activations;

    /// Computes the outputs, `[batch, output_width]`, from the inputs, `[batch, input_size]`. The
    /// first seven outputs of a sample are the action values.
    fn forward(&self, activations: &mut Activations);

    /// Returns copies of the parameters, with the names used in files.
    ///
    /// # Errors
    ///
    /// Returns an error if candle cannot create a tensor.
    fn tensors(&self) -> Result<Vec<(String, Tensor)>>;

    /// Replaces the parameters with saved ones whose names begin with `prefix`.
    ///
    /// # Errors
    ///
    /// Returns an error if a tensor is missing, has the wrong shape, or contains an infinite or NaN
    /// value. The network may then contain some of the new parameters.
    fn read(
        &mut self,
        prefix: &str,
        tensors: &HashMap<String, Tensor>,
    ) -> std::result::Result<(), WeightsError>;

    /// Selects the vector instructions to use. By default, this method does nothing.
    fn set_arch(&mut self, _arch: Arch) {}

    /// Returns a copy that shares no parameters with the original.
    fn clone_box(&self) -> Box<dyn Network>;
}

/// A training network, its optimizer, and the target network.
pub trait Backend: Debug + Send {
    /// Returns the training network (`w_train`).
    fn train(&self) -> &dyn Network;

    /// Returns the target network (`w_target`).
    fn target(&self) -> &dyn Network;

    /// Returns the buffer for the gradient of the loss with respect to the outputs of the training
    /// network, `[batch, output_width]`. [`update`](Backend::update) backpropagates this gradient.
    /// The buffer may be longer than this shape requires.
    fn output_gradient(&mut self) -> &mut [f32];

    /// Updates the training network with one step of Adam, based on the output gradient.
    /// `activations` must hold the training network's forward pass over the same batch.
    fn update(&mut self, activations: &Activations);

    /// Moves the target network towards the training network by the fraction `tau`, 0 to 1 (eq. 6).
    fn update_target(&mut self, tau: f32);

    /// Sets Adam's step size, alpha.
    fn set_learning_rate(&mut self, learning_rate: f64);

    /// Returns the number of updates so far, Adam's `t`.
    fn updates(&self) -> u64;

    /// Sets the number of updates when a training run is resumed.
    fn set_updates(&mut self, updates: u64);

    /// Returns the training network, the target network, and Adam's first and second moments, each
    /// paired with the prefix of its tensors in a checkpoint. The moments have the same shape as
    /// the network.
    fn networks(&self) -> [(&'static str, &dyn Network); 4];

    /// Like [`networks`](Backend::networks), but returns mutable references.
    fn networks_mut(&mut self) -> [(&'static str, &mut dyn Network); 4];

    /// Selects the vector instructions to use. By default, this method does nothing.
    fn set_arch(&mut self, _arch: Arch) {}

    /// Returns a copy that shares no parameters with the original.
    fn clone_box(&self) -> Box<dyn Backend>;
}

/// The prefixes returned by [`Backend::networks`].
pub(crate) const PREFIXES: [&str; 4] = ["train.", "target.", "adam.first.", "adam.second."];

impl Clone for Box<dyn Network> {
    fn clone(&self) -> Box<dyn Network> {
        self.clone_box()
    }
}

impl Clone for Box<dyn Backend> {
    fn clone(&self) -> Box<dyn Backend> {
        self.clone_box()
    }
}
