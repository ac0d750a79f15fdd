//! The results of all variants, in the format of `ablation.json`.

use std::collections::BTreeMap;

use learning::settings::Settings;
use serde::{Deserialize, Serialize};
use sim_node::reality::Randomization;
use task::Evaluation;

use crate::variants::Variant;

/// The randomization of the evaluations.
pub const LEVELS: [Randomization; 2] = [Randomization::None, Randomization::Strong];

/// The results, keyed by [`Variant::name`].
pub type Results = BTreeMap<String, TrainingResult>;

/// The inputs of one training run and the evaluations of its policy.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TrainingResult {
    pub seed: u64,
    pub episodes: u32,
    /// The randomization of the training.
    pub randomization: String,
    pub settings: Settings,
    /// The number of training steps.
    pub steps: u64,
    /// The evaluations in all scenarios, keyed by the randomization of the evaluation.
    pub evaluations: BTreeMap<String, Vec<Evaluation>>,
}

impl TrainingResult {
    /// Returns whether the result is that of a variant with this seed.
    pub fn matches(&self, variant: &Variant, seed: u64) -> bool {
        self.seed == seed
            && self.episodes == variant.episodes
            && self.randomization == variant.randomization.name()
            && self.settings == variant.settings
    }
}
