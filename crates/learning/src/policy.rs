//! What a trained network does.

use candle_core::Result;
use task::{Action, Image};

use super::{
    dyna_q::Decision,
    greedy::{ActionSet, greedy_action},
    network::QNetwork,
    observation::History,
    perceptron::Perceptron,
    settings::Settings,
    valuation::Valuation,
};

/// A trained network at work: it takes the action of the greatest value, and explores nothing.
#[derive(Clone, Debug)]
pub struct Policy {
    network: Perceptron,
    valuation: Valuation,
    avoid_repetition: bool,
    history: History,
}

impl Policy {
    /// The policy of a network, which sees and does as the settings say.
    pub fn new(network: &QNetwork, settings: &Settings) -> Result<Policy> {
        let network = Perceptron::new(network)?;
        let frames = settings.network.observation_frames;
        Ok(Policy {
            valuation: Valuation::new(&network, frames, settings.replay.mirror, 1),
            network,
            avoid_repetition: settings.exploration.avoid_repetition,
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
        let states = std::iter::once(self.history.past());
        let values = self.valuation.of(&self.network, states).next();
        let values = values.unwrap_or([f32::NAN; Action::COUNT]);
        let excluded = match self.avoid_repetition {
            true => self.history.tried(),
            false => ActionSet::NONE,
        };
        let action = greedy_action(&values, excluded);
        Decision { action, values, explored: false }
    }
}
