//! Every number of the method, and the presets that name a set of them.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::exploration::EpsilonDecay;

/// A named set of [`Settings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The paper, exactly.
    Paper,
}

/// Why a name is no preset.
#[derive(Debug, Error, PartialEq)]
#[error("no preset '{0}': expected paper")]
pub struct NoSuchPreset(String);

impl Preset {
    /// Every preset.
    pub const ALL: [Preset; 1] = [Preset::Paper];

    /// The numbers of the preset.
    pub fn settings(self) -> Settings {
        match self {
            Preset::Paper => Settings {
                hidden_layers: vec![64, 128, 64],
                exploration: EpsilonDecay { minimum: 0.1, maximum: 1.0, fraction: 0.5 },
                memory_capacity: 10_000,
                batch_size: 50,
                planning_steps: 1,
                discount: 0.999,
                learning_rate: 1e-4,
                adam_beta1: 0.9,
                adam_beta2: 0.999,
                adam_epsilon: 1e-7,
                target_update: 0.1,
            },
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Preset::Paper => f.write_str("paper"),
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

/// The hyperparameters of deep Dyna-Q.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Neurons of each hidden layer.
    pub hidden_layers: Vec<usize>,
    /// Eq. 4.
    pub exploration: EpsilonDecay,
    /// How many memories are kept; the oldest goes first.
    pub memory_capacity: usize,
    /// How many different memories an update is made from.
    pub batch_size: usize,
    /// Dyna-Q's n: updates per step.
    pub planning_steps: usize,
    /// Gamma.
    pub discount: f64,
    /// Alpha, the step size of Adam.
    pub learning_rate: f64,
    /// Decay of Adam's mean of the gradients.
    pub adam_beta1: f64,
    /// Decay of Adam's mean of the squared gradients.
    pub adam_beta2: f64,
    /// What keeps Adam from dividing by zero; 1e-7 is TensorFlow's.
    pub adam_epsilon: f64,
    /// Tau of eq. 6.
    pub target_update: f64,
}
