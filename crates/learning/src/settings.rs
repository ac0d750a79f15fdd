//! The hyperparameters of deep Dyna-Q, and the presets.
//!
//! # Examples
//!
//! ```
//! use learning::settings::Preset;
//!
//! let preset: Preset = "robust".parse()?;
//! assert_eq!(preset.settings().network.observation_frames, 4);
//!
//! let error = "nonsense".parse::<Preset>().unwrap_err();
//! assert_eq!(error.to_string(), "preset: unknown value 'nonsense' (expected: paper, robust)");
//! # Ok::<(), task::names::UnknownName>(())
//! ```

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

use task::names::{UnknownName, find};

use super::exploration::EpsilonDecay;

/// A named set of [`Settings`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// The hyperparameters of the paper.
    Paper,
    /// The hyperparameters of the paper, with changes that keep the robot from getting stuck and
    /// reduce blocked moves. The ablation in docs/results.md measures the effect of each change.
    #[default]
    Robust,
}

impl Preset {
    /// All presets.
    pub const ALL: [Preset; 2] = [Preset::Paper, Preset::Robust];

    /// Returns the default number of training episodes.
    pub fn episodes(self) -> u32 {
        match self {
            Preset::Paper => 1000,
            Preset::Robust => 9000,
        }
    }

    /// Returns the hyperparameters of the preset.
    pub fn settings(self) -> Settings {
        match self {
            Preset::Paper => Settings {
                network: NetworkSettings {
                    architecture: Architecture::Mlp,
                    hidden_layers: vec![64, 128, 64],
                    observation_frames: 1,
                },
                replay: ReplaySettings {
                    capacity: 10_000,
                    batch_size: 50,
                    planning_steps: 1,
                    update_interval: 1,
                    priority_exponent: 0.0,
                    importance_exponent: 0.0,
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
                robust.network.architecture = Architecture::SharedEncoder;
                robust.network.hidden_layers = vec![64, 192, 96];
                robust.network.observation_frames = 4;
                robust.replay.capacity = 100_000;
                robust.replay.batch_size = 64;
                robust.replay.update_interval = 3;
                robust.replay.priority_exponent = 0.8;
                robust.replay.importance_exponent = 0.5;
                robust.replay.blocked_reward = -1.5;
                robust.replay.mirror = true;
                robust.replay.history_dropout = 0.5;
                robust.exploration.epsilon =
                    EpsilonDecay { minimum: 0.05, maximum: 1.0, fraction: 0.3 };
                robust.exploration.avoid_repetition = true;
                robust.optimizer.learning_rate = 4e-4;
                robust.optimizer.final_learning_rate_ratio = 0.0;
                robust.optimizer.weight_decay = 0.2;
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
    type Err = UnknownName;

    /// Parses `paper` or `robust`.
    ///
    /// # Errors
    ///
    /// Returns [`UnknownName`] for any other name.
    fn from_str(name: &str) -> Result<Preset, UnknownName> {
        find("preset", Preset::ALL, name)
    }
}

/// The architecture of a network, which maps an observation,
/// [`[input_size(frames)]`](super::observation::input_size), to the values of the seven actions,
/// `[7]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Architecture {
    /// A multilayer perceptron, as in the paper: the hidden layers with ReLU, then a linear layer.
    #[default]
    Mlp,
    /// A multilayer perceptron whose first layer, with the number of neurons in the first entry of
    /// [`hidden_layers`](NetworkSettings::hidden_layers), is applied to each stacked image and the
    /// action that led to it, with the same weights. The second layer reads all of its outputs.
    SharedEncoder,
    /// A dueling network (Wang et al., 2016): the hidden layers, then a state value and seven
    /// advantages.
    Dueling,
    /// Two 3 x 3 convolutions over the stacked images, with 16 and 32 channels, and then the hidden
    /// layers.
    Convolutional,
    /// A gated recurrent unit over the stacked images, oldest first, and then the hidden layers.
    /// The first entry of [`hidden_layers`](NetworkSettings::hidden_layers) is the size of the
    /// unit's state.
    Recurrent,
}

impl Architecture {
    /// All architectures.
    pub const ALL: [Architecture; 5] = [
        Architecture::Mlp,
        Architecture::SharedEncoder,
        Architecture::Dueling,
        Architecture::Convolutional,
        Architecture::Recurrent,
    ];
}

impl fmt::Display for Architecture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Architecture::Mlp => "mlp",
            Architecture::SharedEncoder => "shared_encoder",
            Architecture::Dueling => "dueling",
            Architecture::Convolutional => "convolutional",
            Architecture::Recurrent => "recurrent",
        })
    }
}

impl FromStr for Architecture {
    type Err = UnknownName;

    /// Parses `mlp`, `shared_encoder`, `dueling`, `convolutional` or `recurrent`.
    ///
    /// # Errors
    ///
    /// Returns [`UnknownName`] for any other name.
    fn from_str(name: &str) -> Result<Architecture, UnknownName> {
        find("architecture", Architecture::ALL, name)
    }
}

/// When the target network is updated (eq. 6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TargetUpdate {
    /// At the end of each episode, as in the paper.
    Episode,
    /// After each update of the training network.
    Update,
}

impl TargetUpdate {
    /// All variants.
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

impl FromStr for TargetUpdate {
    type Err = UnknownName;

    /// Parses `episode` or `update`.
    ///
    /// # Errors
    ///
    /// Returns [`UnknownName`] for any other name.
    fn from_str(name: &str) -> Result<TargetUpdate, UnknownName> {
        find("target_update_at", TargetUpdate::ALL, name)
    }
}

/// The hyperparameters of deep Dyna-Q, grouped by the part of the learner that uses them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The shape of the network.
    pub network: NetworkSettings,
    /// The replay memory, and the updates that sample from it.
    pub replay: ReplaySettings,
    /// Action selection during training.
    pub exploration: ExplorationSettings,
    /// The optimizer.
    pub optimizer: OptimizerSettings,
    /// The target values and the target network.
    pub target: TargetSettings,
}

impl Settings {
    /// Returns these settings after applying `change`.
    ///
    /// # Examples
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

/// The shape of the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NetworkSettings {
    /// The architecture. Checkpoints without this field contain multilayer perceptrons.
    #[serde(default)]
    pub architecture: Architecture,
    /// Number of neurons in each hidden layer.
    pub hidden_layers: Vec<usize>,
    /// Number of stacked images in an observation: the current image and the previous ones, with
    /// the actions between them. At least 1.
    pub observation_frames: usize,
}

/// The replay memory, and the updates that sample from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReplaySettings {
    /// Maximum number of stored transitions; once the replay memory is full, a new transition
    /// replaces the oldest.
    pub capacity: usize,
    /// Number of transitions in a batch. With uniform sampling, all of them are distinct.
    pub batch_size: usize,
    /// Number of updates after every [`update_interval`](Self::update_interval)-th step: `n` in
    /// Dyna-Q.
    pub planning_steps: usize,
    /// Number of steps between updates, at least 1: `planning_steps` updates follow every
    /// `update_interval`-th step of the training run.
    #[serde(default = "every_step")]
    pub update_interval: usize,
    /// Prioritized experience replay: the exponent alpha of Schaul et al. (2016), 0 to 1. With 0,
    /// transitions are sampled uniformly.
    #[serde(default)]
    pub priority_exponent: f64,
    /// Prioritized experience replay: the exponent beta of the importance-sampling weights at the
    /// start of training, 0 to 1. It increases linearly to 1 with the fraction of finished
    /// episodes. Has no effect with uniform sampling.
    #[serde(default)]
    pub importance_exponent: f64,
    /// Extra reward added to the stored reward of a blocked move.
    pub blocked_reward: f64,
    /// Whether each sampled transition is mirrored with probability 0.5: left and right are swapped
    /// in its images and actions, which gives a transition in the mirrored room. If true, the agent
    /// also acts on the mean of the action values of a state and its mirror image.
    pub mirror: bool,
    /// Probability, 0 to 1, that a sampled transition keeps only its most recent images. The number
    /// of images kept is drawn uniformly from 1 to `observation_frames`, and is the same for the
    /// state and the next state.
    pub history_dropout: f64,
}

/// The default of [`ReplaySettings::update_interval`].
fn every_step() -> usize {
    1
}

/// Action selection during training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExplorationSettings {
    /// The decay of epsilon (eq. 4).
    pub epsilon: EpsilonDecay,
    /// Whether to exclude actions that were already taken in response to the same view within the
    /// last [`HORIZON`](super::observation::HORIZON) steps of the episode. Applies to
    /// exploration, greedy actions, policies and the choice of the next action in eq. 5.
    pub avoid_repetition: bool,
}

/// The hyperparameters of Adam (Kingma and Ba, 2017) with decoupled weight decay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptimizerSettings {
    /// The step size alpha at the start of training.
    pub learning_rate: f64,
    /// Step size at the end of training as a fraction of `learning_rate`, 0 to 1; the step size
    /// changes linearly with the fraction of finished episodes.
    pub final_learning_rate_ratio: f64,
    /// Decoupled weight decay (Loshchilov and Hutter, 2019): each update first multiplies all
    /// weights and biases by `1 - alpha * weight_decay`.
    pub weight_decay: f64,
    /// Decay rate of the mean of the gradients.
    pub beta1: f64,
    /// Decay rate of the mean of the squared gradients.
    pub beta2: f64,
    /// Constant added to the denominator of the step; 1e-7 is TensorFlow's default.
    pub epsilon: f64,
}

/// The target values (eq. 5) and the update of the target network (eq. 6).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TargetSettings {
    /// The discount factor gamma.
    pub discount: f64,
    /// Double Q-learning (van Hasselt, Guez and Silver, 2016): the training network selects the
    /// next action, and the target network evaluates it.
    pub double_q: bool,
    /// The rate tau in eq. 6, 0 to 1.
    pub rate: f64,
    /// When the target network is updated.
    pub update_at: TargetUpdate,
}
