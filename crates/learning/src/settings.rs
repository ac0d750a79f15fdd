//! Every number of the method, and the presets that name a set of them.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::exploration::EpsilonDecay;

/// A named set of [`Settings`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// The paper, exactly.
    Paper,
    /// What makes a robot that neither gets stuck nor bumps. docs/results.md shows what becomes of it
    /// without each of its ingredients.
    #[default]
    Robust,
}

/// Why a name is no preset.
#[derive(Debug, Error, PartialEq)]
#[error("no preset '{0}': expected paper or robust")]
pub struct NoSuchPreset(String);

impl Preset {
    /// Every preset.
    pub const ALL: [Preset; 2] = [Preset::Paper, Preset::Robust];

    /// How many training episodes it takes.
    pub fn episodes(self) -> u32 {
        match self {
            Preset::Paper => 1000,
            Preset::Robust => 3000,
        }
    }

    /// The numbers of the preset.
    pub fn settings(self) -> Settings {
        match self {
            Preset::Paper => Settings {
                network: NetworkSettings {
                    hidden_layers: vec![64, 128, 64],
                    observation_frames: 1,
                },
                replay: ReplaySettings {
                    capacity: 10_000,
                    batch_size: 50,
                    planning_steps: 1,
                    blocked_reward: 0.0,
                    mirror: false,
                    history_dropout: 0.0,
                },
                exploration: ExplorationSettings {
                    epsilon: EpsilonDecay { minimum: 0.1, maximum: 1.0, fraction: 0.5 },
                    avoid_repetition: false,
                },
                optimizer: OptimizerSettings {
                    learning_rate: 1e-4,
                    final_learning_rate_ratio: 1.0,
                    weight_decay: 0.0,
                    beta1: 0.9,
                    beta2: 0.999,
                    epsilon: 1e-7,
                },
                target: TargetSettings {
                    discount: 0.999,
                    double_q: false,
                    rate: 0.1,
                    update_at: TargetUpdate::Episode,
                },
            },
            Preset::Robust => Preset::Paper.settings().with(|robust| {
                robust.network.observation_frames = 4;
                robust.replay.capacity = 50_000;
                robust.replay.batch_size = 64;
                robust.replay.blocked_reward = -0.7;
                robust.replay.mirror = true;
                robust.replay.history_dropout = 0.5;
                robust.exploration.epsilon =
                    EpsilonDecay { minimum: 0.05, maximum: 1.0, fraction: 0.3 };
                robust.exploration.avoid_repetition = true;
                robust.optimizer.final_learning_rate_ratio = 0.0;
                robust.optimizer.weight_decay = 0.5;
                robust.target.discount = 0.99;
                robust.target.rate = 0.005;
                robust.target.update_at = TargetUpdate::Update;
            }),
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Preset::Paper => f.write_str("paper"),
            Preset::Robust => f.write_str("robust"),
        }
    }
}

impl FromStr for Preset {
    type Err = NoSuchPreset;

    fn from_str(name: &str) -> Result<Preset, NoSuchPreset> {
        let preset = Preset::ALL.into_iter().find(|preset| preset.to_string() == name);
        preset.ok_or_else(|| NoSuchPreset(name.to_owned()))
    }
}

/// When the target network follows the training network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TargetUpdate {
    /// At the end of each episode, as in the paper.
    Episode,
    /// After each update of the training network.
    Update,
}

impl TargetUpdate {
    /// Both.
    pub const ALL: [TargetUpdate; 2] = [TargetUpdate::Episode, TargetUpdate::Update];
}

impl fmt::Display for TargetUpdate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TargetUpdate::Episode => f.write_str("episode"),
            TargetUpdate::Update => f.write_str("update"),
        }
    }
}

/// Why a word says no [`TargetUpdate`].
#[derive(Debug, Error, PartialEq)]
#[error("'{0}' is no time for an update of the target network: expected episode or update")]
pub struct NoSuchTargetUpdate(String);

impl FromStr for TargetUpdate {
    type Err = NoSuchTargetUpdate;

    fn from_str(name: &str) -> Result<TargetUpdate, NoSuchTargetUpdate> {
        let when = TargetUpdate::ALL.into_iter().find(|when| when.to_string() == name);
        when.ok_or_else(|| NoSuchTargetUpdate(name.to_owned()))
    }
}

/// The hyperparameters of deep Dyna-Q, by the part of the learner that goes by them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The form of the network.
    pub network: NetworkSettings,
    /// The replay memory, and the updates from it.
    pub replay: ReplaySettings,
    /// Which actions are tried.
    pub exploration: ExplorationSettings,
    /// How a weight moves.
    pub optimizer: OptimizerSettings,
    /// What the values are learnt towards.
    pub target: TargetSettings,
}

impl Settings {
    /// These settings with a change.
    ///
    /// ```
    /// use learning::settings::Preset;
    ///
    /// let small = Preset::Paper.settings().with(|settings| settings.replay.capacity = 100);
    /// assert_eq!((small.replay.capacity, small.replay.batch_size), (100, 50));
    /// ```
    pub fn with(mut self, change: impl FnOnce(&mut Settings)) -> Settings {
        change(&mut self);
        self
    }
}

/// The form of the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NetworkSettings {
    /// Neurons of each hidden layer.
    pub hidden_layers: Vec<usize>,
    /// How many images an observation holds: the present one and those before it, with the actions
    /// between them.
    pub observation_frames: usize,
}

/// The replay memory, and the updates from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReplaySettings {
    /// How many experiences are kept; the oldest goes first.
    pub capacity: usize,
    /// How many different experiences an update is made from.
    pub batch_size: usize,
    /// Dyna-Q's n: updates per step.
    pub planning_steps: usize,
    /// What a blocked move adds to the reward that is remembered.
    pub blocked_reward: f64,
    /// Whether half of the experiences that an update draws are seen in a mirror: left and right of
    /// images and actions exchanged, which is the room as another one could be. A decision then sees
    /// its state both ways.
    pub mirror: bool,
    /// The share of the experiences that an update draws of which only some of the images are seen, as
    /// many of the next state as of the state.
    pub history_dropout: f64,
}

/// Which actions are tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExplorationSettings {
    /// Eq. 4.
    pub epsilon: EpsilonDecay,
    /// Whether an action is left out that was tried from the very same image, not long ago in this
    /// episode ([`HORIZON`](super::observation::HORIZON)).
    pub avoid_repetition: bool,
}

/// How a weight moves: Adam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptimizerSettings {
    /// Alpha, the step size.
    pub learning_rate: f64,
    /// What share of alpha is left at the end of the training, a straight line from the beginning.
    pub final_learning_rate_ratio: f64,
    /// By what a weight shrinks in an update, in units of alpha (Loshchilov and Hutter, 2019).
    pub weight_decay: f64,
    /// Decay of the mean of the gradients.
    pub beta1: f64,
    /// Decay of the mean of the squared gradients.
    pub beta2: f64,
    /// What keeps Adam from dividing by zero; 1e-7 is TensorFlow's.
    pub epsilon: f64,
}

/// What the values are learnt towards (eq. 5), and how the target network follows (eq. 6).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TargetSettings {
    /// Gamma.
    pub discount: f64,
    /// Whether the training network chooses the action that the target network values (double
    /// Q-learning: van Hasselt, Guez and Silver, 2016).
    pub double_q: bool,
    /// Tau of eq. 6.
    pub rate: f64,
    /// When eq. 6 is applied.
    pub update_at: TargetUpdate,
}
