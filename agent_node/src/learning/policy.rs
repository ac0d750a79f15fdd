//! What a network makes of an image.

use candle_core::Result;

use super::{
    action::Action,
    image::Image,
    network::QNetwork,
    perceptron::{Activations, Perceptron},
};

/// A trained network at work.
#[derive(Clone, Debug)]
pub struct Policy {
    network: Perceptron,
    activations: Activations,
}

impl Policy {
    /// The policy of a network.
    pub fn new(network: &QNetwork) -> Result<Policy> {
        let network = Perceptron::new(network)?;
        let activations = network.activations(1);
        Ok(Policy { network, activations })
    }

    /// The values of the seven actions in one state.
    pub fn values(&mut self, image: &Image) -> [f32; Action::COUNT] {
        values(&self.network, &mut self.activations, image)
    }
}

/// The values that a network gives the seven actions in one state; the activations are of a batch
/// of one.
pub(super) fn values(
    network: &Perceptron,
    activations: &mut Activations,
    image: &Image,
) -> [f32; Action::COUNT] {
    activations.read_images(std::iter::once(image.bytes()));
    network.forward(activations);
    activations.outputs().next().map_or([f32::NAN; Action::COUNT], of_actions)
}

/// The values of the actions among the outputs for a state, behind which there is padding.
pub(super) fn of_actions(outputs: &[f32]) -> [f32; Action::COUNT] {
    let mut values = [0.0; Action::COUNT];
    values.copy_from_slice(&outputs[..Action::COUNT]);
    values
}
