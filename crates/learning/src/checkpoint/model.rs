//! The weights of a network in a file of their own.

use std::{collections::HashMap, path::Path};

use candle_core::Tensor;

use super::{
    file::{File, read},
    load_error::{LoadError, does_not_fit},
};
use crate::{
    network::{QNetwork, WeightsError},
    observation::input_size,
    perceptron::Perceptron,
    settings::Settings,
};

/// The bytes of `model.safetensors`: the weights of a network, and nothing else.
pub fn model_bytes(network: &Perceptron) -> Result<Vec<u8>, candle_core::Error> {
    Ok(safetensors::serialize(network.network()?.tensors(), None)?)
}

/// A trained network from `model.safetensors`.
pub fn load_model(path: &Path, settings: &Settings) -> Result<QNetwork, LoadError> {
    let bytes = read(path)?;
    let file = File::parse(path, &bytes)?;
    let tensors = file.tensors().map_err(|error| file.damaged(error))?;
    network("", settings, &tensors).map_err(|error| does_not_fit(path, error))
}

/// The network that a file holds under names with this prefix.
pub(super) fn network(
    prefix: &str,
    settings: &Settings,
    tensors: &HashMap<String, Tensor>,
) -> Result<QNetwork, WeightsError> {
    let inputs = input_size(settings.network.observation_frames);
    QNetwork::from_tensors(prefix, inputs, &settings.network.hidden_layers, tensors)
}
