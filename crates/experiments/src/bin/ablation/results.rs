//! The results of all variants, in the format of `ablation.json`.

use std::collections::BTreeMap;

use learning::settings::Settings;
use serde::{Deserialize, Serialize};
use task::Evaluation;

use crate::variants::Variant;

/// The results, keyed by [`Variant::key`] and then by scenario.
pub type Results = BTreeMap<String, BTreeMap<String, TrainingResult>>;

/// The inputs of one training run and the evaluation of its policy.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TrainingResult {
    pub seed: u64,
    pub episodes: u32,
    pub settings: Settings,
    pub evaluation: Evaluation,
}

impl TrainingResult {
    /// Returns whether the result is that of a variant with this seed.
    pub fn matches(&self, variant: &Variant, seed: u64) -> bool {
        let TrainingResult { settings, .. } = self;
        (self.seed, self.episodes, settings) == (seed, variant.episodes, &variant.settings)
    }
}
