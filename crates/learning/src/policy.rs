//! The greedy policy of a network.

use task::{Action, Image};

use super::{
    backend::Network,
    dyna_q::Decision,
    greedy::{ActionSet, greedy_action},
    observation::History,
    settings::Settings,
    valuation::Valuation,
};

/// A policy that takes the action with the highest value and does not explore.
///
/// An episode starts with [`begin`](Policy::begin); then [`decide`](Policy::decide) and
/// [`observe`](Policy::observe) alternate.
///
/// # Examples
///
/// ```
/// use learning::{architectures::backend, policy::Policy, settings::Preset};
/// use task::{Image, Random};
///
/// let settings = Preset::Robust.settings();
/// let backend = backend(&settings, &mut Random::from_key([0; 4]))?;
/// let mut policy = Policy::new(backend.train().clone_box(), &settings);
///
/// let image = Image::try_from(vec![0u8; Image::BYTES])?;
/// policy.begin(image.clone());
/// let first = policy.decide();
/// policy.observe(first.action, image);
/// // The image is unchanged, so the policy does not repeat the action.
/// assert_ne!(policy.decide().action, first.action);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Policy {
    network: Box<dyn Network>,
    valuation: Valuation,
    avoid_repetition: bool,
    history: History,
}

impl Policy {
    /// Creates a policy from a network.
    ///
    /// `settings` must be the settings that the network was trained with: they determine the shape
    /// of the observations, whether values are averaged over an observation and its mirror image,
    /// and which actions are excluded.
    pub fn new(network: Box<dyn Network>, settings: &Settings) -> Policy {
        let frames = settings.network.observation_frames;
        Policy {
            valuation: Valuation::new(&*network, frames, settings.replay.mirror, 1),
            network,
            avoid_repetition: settings.exploration.avoid_repetition,
            history: History::new(frames),
        }
    }

    /// Starts an episode with its first image.
    pub fn begin(&mut self, image: Image) {
        self.history.begin(image);
    }

    /// Adds the image that followed an action.
    pub fn observe(&mut self, action: Action, image: Image) {
        self.history.push(action, image);
    }

    /// Returns the action for the current observation, and the values of all actions.
    ///
    /// [`begin`](Policy::begin) must be called first.
    pub fn decide(&mut self) -> Decision {
        let states = std::iter::once(self.history.past());
        let values = self.valuation.of(&*self.network, states).next();
        let values = values.unwrap_or([f32::NAN; Action::COUNT]);
        let excluded = match self.avoid_repetition {
            true => self.history.tried(),
            false => ActionSet::NONE,
        };
        let action = greedy_action(&values, excluded);
        Decision { action, values, explored: false }
    }
}
