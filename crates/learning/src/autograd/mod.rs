//! The backend for all architectures except the multilayer perceptron. It uses candle's tensors and
//! automatic differentiation, and implements Adam with tensor operations.
//!
//! It is meant for experimenting with architectures: an update takes 5 to 50 times as long as
//! with the [kernels](crate::perceptron). Results are reproducible on the same machine. Unlike the
//! kernels' results, they may differ in the last bits between processors, since the summation order
//! in candle's matrix product depends on the vector width.
//!
//! # Examples
//!
//! ```
//! use learning::{
//!     autograd::CandleNetwork,
//!     backend::Network,
//!     settings::{Architecture, Preset},
//! };
//! use task::Random;
//!
//! let settings = Preset::Robust.settings().with(|s| {
//!     s.network.architecture = Architecture::Dueling;
//! });
//! let network = CandleNetwork::new(&settings.network, &mut Random::from_key([0; 4]))?;
//! let mut activations = network.activations(2);
//! network.forward(&mut activations);
//! // The weights of the output layers start at zero.
//! assert!(activations.outputs().all(|values| *values == [0.0; 7]));
//! # Ok::<(), candle_core::Error>(())
//! ```

mod model;
mod variables;

use std::collections::HashMap;

use candle_core::{DType, Device, Result, Tensor, Var, backprop::GradStore};
use pulp::Arch;
use task::{Action, Random};

use self::{model::Model, variables::Variables};
use crate::{
    activations::Activations,
    backend::{Backend, Network, PREFIXES},
    observation::input_size,
    optimizer::Rates,
    settings::{NetworkSettings, OptimizerSettings},
    weights::{WeightsError, he_normal, normal, saved},
};

/// The panic message of tensor operations, which states why they cannot fail during training.
const CHECKED: &str = "the shapes of all tensors are fixed when the network is created";

/// A Q-network made of candle tensors.
#[derive(Debug)]
pub struct CandleNetwork {
    settings: NetworkSettings,
    variables: Variables,
    model: Model,
}

impl CandleNetwork {
    /// Creates a network with zeros in the output layers (see
    /// [`QNetwork::new`](crate::network::QNetwork::new)) and in all biases. The other weights are
    /// normally distributed: with standard deviation `sqrt(1 / inputs)` in the gated recurrent
    /// unit, and He-normal in all other layers.
    ///
    /// # Errors
    ///
    /// Returns an error if the settings do not describe a valid network.
    pub fn new(settings: &NetworkSettings, random: &mut Random) -> Result<CandleNetwork> {
        CandleNetwork::with(settings, &mut |name, shape| {
            let inputs: usize = shape[1..].iter().product();
            if name.ends_with("bias") || name.contains("bias_") || model::is_output(name) {
                Tensor::zeros(shape, DType::F32, &Device::Cpu)
            } else if name.starts_with("gru.") {
                // The unit has no ReLUs, so the factor of 2 in the He-normal variance is omitted.
                normal(shape, (1.0 / inputs as f32).sqrt(), random)
            } else {
                he_normal(shape, inputs, random)
            }
        })
    }

    /// Creates a network from saved parameters whose names begin with `prefix`.
    ///
    /// # Errors
    ///
    /// Returns an error if a tensor is missing, has the wrong shape, or contains an infinite or NaN
    /// value.
    pub fn from_tensors(
        settings: &NetworkSettings,
        prefix: &str,
        tensors: &HashMap<String, Tensor>,
    ) -> std::result::Result<CandleNetwork, WeightsError> {
        // The reason is kept apart: candle's errors can carry a backtrace in their text.
        let mut reason = None;
        let network = CandleNetwork::with(settings, &mut |name, shape| {
            saved(tensors, format!("{prefix}{name}"), shape).map_err(|error| {
                let message = error.to_string();
                reason = Some(error);
                candle_core::Error::Msg(message)
            })
        });
        network.map_err(|error| reason.unwrap_or(WeightsError::Candle(error)))
    }

    /// Creates a network, calling `make` for each parameter.
    fn with(settings: &NetworkSettings, make: &mut variables::Make<'_>) -> Result<CandleNetwork> {
        let (variables, model) = Variables::make(make, |builder| Model::new(settings, builder))?;
        Ok(CandleNetwork { settings: settings.clone(), variables, model })
    }

    /// Returns a network of the same shape, filled with zeros.
    fn zeros_like(&self) -> Result<CandleNetwork> {
        CandleNetwork::with(&self.settings, &mut |name, _| self.variables.get(name)?.zeros_like())
    }

    /// Computes the outputs, `[batch, 7]`, and records the operations for [`Tensor::backward`].
    fn outputs(&self, activations: &Activations) -> Result<Tensor> {
        let shape = (activations.batch(), input_size(self.settings.observation_frames));
        self.model.forward(&Tensor::from_slice(&activations.inputs, shape, &Device::Cpu)?)
    }
}

impl Clone for CandleNetwork {
    /// Copies the parameters; cloning candle tensors would share their data.
    fn clone(&self) -> CandleNetwork {
        let copy =
            CandleNetwork::with(&self.settings, &mut |name, _| self.variables.get(name)?.copy());
        copy.expect(CHECKED)
    }
}

impl Network for CandleNetwork {
    fn activations(&self, batch: usize) -> Activations {
        let inputs = input_size(self.settings.observation_frames);
        Activations::new(batch, inputs, [Action::COUNT], Arch::new())
    }

    fn forward(&self, activations: &mut Activations) {
        let outputs = self.outputs(activations).and_then(|outputs| outputs.flatten_all());
        let outputs: Vec<f32> = outputs.and_then(|outputs| outputs.to_vec1()).expect(CHECKED);
        if let Some(values) = activations.outputs.last_mut() {
            values.copy_from_slice(&outputs);
        }
    }

    fn tensors(&self) -> Result<Vec<(String, Tensor)>> {
        // The tensors are copied because updates change the variables in place.
        self.variables.iter().map(|(name, value)| Ok((name.to_owned(), value.copy()?))).collect()
    }

    fn read(
        &mut self,
        prefix: &str,
        tensors: &HashMap<String, Tensor>,
    ) -> std::result::Result<(), WeightsError> {
        *self = CandleNetwork::from_tensors(&self.settings, prefix, tensors)?;
        Ok(())
    }

    fn clone_box(&self) -> Box<dyn Network> {
        Box::new(self.clone())
    }
}

/// A training network, its target network, and Adam's moments.
#[derive(Clone, Debug)]
pub struct Autograd {
    train: CandleNetwork,
    target: CandleNetwork,
    first: CandleNetwork,
    second: CandleNetwork,
    settings: OptimizerSettings,
    learning_rate: f64,
    updates: u64,
    /// `[batch, 7]`
    output_gradient: Vec<f32>,
}

impl Autograd {
    /// Creates a backend for batches of `batch` samples. The target network is a copy of `train`.
    ///
    /// # Errors
    ///
    /// Returns an error if candle cannot create a tensor.
    pub fn new(
        train: CandleNetwork,
        batch: usize,
        settings: &OptimizerSettings,
    ) -> Result<Autograd> {
        Ok(Autograd {
            first: train.zeros_like()?,
            second: train.zeros_like()?,
            target: train.clone(),
            train,
            settings: settings.clone(),
            learning_rate: settings.learning_rate,
            updates: 0,
            output_gradient: vec![0.0; batch * Action::COUNT],
        })
    }

    /// Returns the gradients of the loss with respect to the parameters. They are computed as the
    /// gradients of the dot product of the outputs and the output gradient.
    fn gradients(&self, activations: &Activations) -> Result<GradStore> {
        let shape = (activations.batch(), Action::COUNT);
        let gradient = Tensor::from_slice(&self.output_gradient, shape, &Device::Cpu)?;
        (self.train.outputs(activations)? * gradient)?.sum_all()?.backward()
    }

    /// Updates the parameters with one step of Adam.
    fn descend(&mut self, gradients: &GradStore) -> Result<()> {
        let rates = Rates::new(&self.settings, self.learning_rate, self.updates);
        let scaled = |tensor: &Tensor, factor: f32| tensor.affine(factor.into(), 0.0);
        for (name, weight) in self.train.variables.iter() {
            let Some(gradient) = gradients.get(weight) else { continue };
            let first = self.first.variables.get(name)?;
            let second = self.second.variables.get(name)?;
            first.set(&(scaled(first, rates.beta1)? + scaled(gradient, rates.rest1)?)?)?;
            second
                .set(&(scaled(second, rates.beta2)? + scaled(&gradient.sqr()?, rates.rest2)?)?)?;
            let deviation = second.sqrt()?.affine(1.0, rates.epsilon.into())?;
            let step = scaled(&(first.as_tensor() / deviation)?, rates.rate)?;
            weight.set(&(scaled(weight, rates.keep)? - step)?)?;
        }
        Ok(())
    }
}

impl Backend for Autograd {
    fn train(&self) -> &dyn Network {
        &self.train
    }

    fn target(&self) -> &dyn Network {
        &self.target
    }

    fn output_gradient(&mut self) -> &mut [f32] {
        &mut self.output_gradient
    }

    fn update(&mut self, activations: &Activations) {
        self.updates += 1;
        let gradients = self.gradients(activations);
        gradients.and_then(|gradients| self.descend(&gradients)).expect(CHECKED);
    }

    fn update_target(&mut self, tau: f32) {
        let follow = |(name, weight): (&str, &Var)| -> Result<()> {
            let target = self.target.variables.get(name)?;
            let step = (weight.as_tensor() - target.as_tensor())?.affine(tau.into(), 0.0)?;
            target.set(&(target.as_tensor() + step)?)
        };
        self.train.variables.iter().try_for_each(follow).expect(CHECKED);
    }

    fn set_learning_rate(&mut self, learning_rate: f64) {
        self.learning_rate = learning_rate;
    }

    fn updates(&self) -> u64 {
        self.updates
    }

    fn set_updates(&mut self, updates: u64) {
        self.updates = updates;
    }

    fn networks(&self) -> [(&'static str, &dyn Network); 4] {
        let [a, b, c, d] = PREFIXES;
        [(a, &self.train), (b, &self.target), (c, &self.first), (d, &self.second)]
    }

    fn networks_mut(&mut self) -> [(&'static str, &mut dyn Network); 4] {
        let [a, b, c, d] = PREFIXES;
        [(a, &mut self.train), (b, &mut self.target), (c, &mut self.first), (d, &mut self.second)]
    }

    fn clone_box(&self) -> Box<dyn Backend> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests;
