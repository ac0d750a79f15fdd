//! Initial weights of a network, and validation of saved weights.

use std::collections::HashMap;

use candle_core::{DType, Device, Result, Tensor};
use task::Random;
use thiserror::Error;

/// The error for tensors that are not the weights of a network.
#[derive(Debug, Error)]
pub enum WeightsError {
    /// A tensor is missing.
    #[error("missing tensor '{0}'")]
    Missing(String),
    /// A tensor does not have the shape that the network needs.
    #[error("tensor '{name}' has shape {found:?} (expected: {expected:?}, from config.yaml)")]
    Shape {
        /// The name of the tensor.
        name: String,
        /// The shape of the tensor.
        found: Vec<usize>,
        /// The shape that the network needs.
        expected: Vec<usize>,
    },
    /// A tensor contains an infinite or NaN value.
    #[error("tensor '{0}' contains an infinite or NaN value")]
    NotFinite(String),
    /// A candle operation failed.
    #[error(transparent)]
    Candle(#[from] candle_core::Error),
}

/// Returns a tensor of He-normal weights: mean 0, standard deviation `sqrt(2 / inputs)`, truncated
/// at two standard deviations as in TensorFlow, which the paper uses.
pub(crate) fn he_normal(shape: &[usize], inputs: usize, random: &mut Random) -> Result<Tensor> {
    let deviation = (2.0 / inputs as f32).sqrt();
    normal(shape, deviation, random)
}

/// Returns a tensor of samples from a truncated normal distribution with mean 0 and standard
/// deviation `deviation`.
pub(crate) fn normal(shape: &[usize], deviation: f32, random: &mut Random) -> Result<Tensor> {
    let count: usize = shape.iter().product();
    let numbers: Vec<f32> = (0..count).map(|_| deviation * truncated_normal(random)).collect();
    Tensor::from_vec(numbers, shape, &Device::Cpu)
}

/// Returns a saved tensor as 32-bit floats if it has the expected shape and contains only finite
/// numbers.
pub(crate) fn saved(
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

/// Samples a standard normal distribution truncated at -2 and 2, scaled to a standard deviation of
/// 1.
fn truncated_normal(random: &mut Random) -> f32 {
    /// The standard deviation of a standard normal distribution truncated at -2 and 2.
    const DEVIATION: f32 = 0.879_625_7;
    loop {
        let number = random.normal(1.0) as f32;
        if number.abs() <= 2.0 {
            return number / DEVIATION;
        }
    }
}
