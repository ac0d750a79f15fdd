//! What a trained network does.

use candle_core::Result;

use super::{
    action::{Action, ActionSet},
    dyna_q::Decision,
    image::Image,
    network::QNetwork,
    observation::{History, View},
    perceptron::{Activations, Perceptron},
    settings::Settings,
};

/// A trained network at work: it takes the action of the greatest value, and explores nothing.
#[derive(Clone, Debug)]
pub struct Policy {
    network: Perceptron,
    activations: Activations,
    frames: usize,
    avoid_repetition: bool,
    history: History,
}

impl Policy {
    /// The policy of a network, which sees and does as the settings say.
    pub fn new(network: &QNetwork, settings: &Settings) -> Result<Policy> {
        let network = Perceptron::new(network)?;
        let Settings { observation_frames: frames, avoid_repetition, .. } = *settings;
        Ok(Policy {
            activations: network.activations(1),
            network,
            frames,
            avoid_repetition,
            history: History::new(frames),
        })
    }

    /// An episode begins with what the robot sees.
    pub fn begin(&mut self, image: Image) {
        self.history.begin(image);
    }

    /// An action has led to what the robot sees.
    pub fn observe(&mut self, action: Action, image: Image) {
        self.history.push(action, image);
    }

    /// What it does now, and the values of all actions.
    pub fn decide(&mut self) -> Decision {
        let observation = std::iter::once((self.history.past(), View::PLAIN));
        self.activations.read_observations(self.frames, observation);
        self.network.forward(&mut self.activations);
        let outputs = self.activations.outputs().next();
        let values = outputs.map_or([f32::NAN; Action::COUNT], of_actions);
        let excluded = match self.avoid_repetition {
            true => self.history.tried(),
            false => ActionSet::NONE,
        };
        let action = Action::greatest(&values, excluded);
        Decision { action, values: Some(values), explored: false }
    }
}

/// The values of the actions among the outputs for a state, behind which there is padding.
pub(super) fn of_actions(outputs: &[f32]) -> [f32; Action::COUNT] {
    let mut values = [0.0; Action::COUNT];
    values.copy_from_slice(&outputs[..Action::COUNT]);
    values
}
