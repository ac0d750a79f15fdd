//! Creates the backend or the network for an architecture, using SIMD kernels for multilayer
//! perceptrons and candle for all other architectures.

use std::collections::HashMap;

use candle_core::{Result, Tensor};
use task::Random;

use crate::{
    autograd::{Autograd, CandleNetwork},
    backend::{Backend, Network},
    network::{QNetwork, Shape},
    perceptron::{Kernels, Perceptron},
    settings::{Architecture, NetworkSettings, Settings},
    weights::WeightsError,
};

/// Creates the training network with random weights, a copy of it as the target network, and the
/// optimizer.
///
/// # Errors
///
/// Returns an error if the settings do not describe a valid network, e.g. if the architecture is
/// shared_encoder or recurrent but there are no hidden layers.
///
/// # Examples
///
/// ```
/// use learning::{
///     architectures::backend,
///     settings::{Architecture, Preset},
/// };
/// use task::Random;
///
/// let settings =
///     Preset::Robust.settings().with(|s| s.network.architecture = Architecture::Dueling);
/// let backend = backend(&settings, &mut Random::from_key([0; 4]))?;
/// let names = backend.train().tensors()?.into_iter().map(|(name, _)| name);
/// assert!(names.collect::<Vec<_>>().contains(&"advantage.weight".to_owned()));
/// # Ok::<(), candle_core::Error>(())
/// ```
pub fn backend(settings: &Settings, random: &mut Random) -> Result<Box<dyn Backend>> {
    let Settings { network, optimizer, .. } = settings;
    let batch = settings.replay.batch_size;
    Ok(match network.architecture {
        Architecture::Mlp | Architecture::SharedEncoder => {
            let network = QNetwork::new(&Shape::of(network), random)?;
            Box::new(Kernels::new(&network, batch, optimizer)?)
        }
        _ => Box::new(Autograd::new(CandleNetwork::new(network, random)?, batch, optimizer)?),
    })
}

/// Creates a network from saved tensors whose names begin with `prefix`.
///
/// The shape of each tensor is checked before anything is allocated for it, so settings read from a
/// file cannot cause an excessive allocation.
///
/// # Errors
///
/// Returns an error if a tensor is missing, has the wrong shape, or contains an infinite or NaN
/// value.
pub fn network(
    settings: &NetworkSettings,
    prefix: &str,
    tensors: &HashMap<String, Tensor>,
) -> std::result::Result<Box<dyn Network>, WeightsError> {
    Ok(match settings.architecture {
        Architecture::Mlp | Architecture::SharedEncoder => {
            let network = QNetwork::from_tensors(prefix, &Shape::of(settings), tensors)?;
            Box::new(Perceptron::new(&network)?)
        }
        _ => Box::new(CandleNetwork::from_tensors(settings, prefix, tensors)?),
    })
}
