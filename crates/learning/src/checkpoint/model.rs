//! A file that contains the weights of a network.

use std::path::Path;

use super::{
    file::{File, read},
    load_error::{LoadError, mismatch},
};
use crate::{architectures::network, backend::Network, settings::Settings};

/// Returns the bytes of `model.safetensors`, which contains only the weights of a network.
///
/// # Errors
///
/// Returns an error if candle cannot convert a tensor.
pub fn model_bytes(network: &dyn Network) -> Result<Vec<u8>, candle_core::Error> {
    Ok(safetensors::serialize(network.tensors()?, None)?)
}

/// Reads a network from `model.safetensors`; the settings describe its shape.
///
/// # Errors
///
/// Returns an error if the file cannot be read, is damaged, or contains a network with a different
/// shape or with an infinite or NaN value.
///
/// # Examples
///
/// ```
/// use learning::{
///     architectures::backend,
///     checkpoint::{load_model, model_bytes},
///     settings::Preset,
/// };
/// use task::Random;
///
/// let settings = Preset::Paper.settings();
/// let backend = backend(&settings, &mut Random::from_key([0; 4]))?;
/// let directory = tempfile::tempdir()?;
/// let path = directory.path().join("model.safetensors");
/// std::fs::write(&path, model_bytes(backend.train())?)?;
///
/// let network = load_model(&path, &settings)?;
/// assert_eq!(model_bytes(&*network)?, std::fs::read(&path)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn load_model(path: &Path, settings: &Settings) -> Result<Box<dyn Network>, LoadError> {
    let bytes = read(path)?;
    let file = File::parse(path, &bytes)?;
    let tensors = file.tensors().map_err(|error| file.damaged(error))?;
    network(&settings.network, "", &tensors).map_err(|error| mismatch(path, error))
}
