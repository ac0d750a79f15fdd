//! The fewest steps that lead out of the rooms of a test, which only the simulator can know: it has
//! their plans.

use std::num::NonZeroU64;

use serde::{Deserialize, Serialize};

use crate::seeds::{Purpose, episode_seed};

/// What `sim_node oracle` prints, as JSON, and `agent_node` reads for the measures of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FewestSteps {
    /// The scenario of every reset.
    pub scenario: String,
    /// The seeds of the resets.
    pub seeds: Vec<NonZeroU64>,
    /// For each seed; null where obstacles move, or where there is no way out.
    pub steps: Vec<Option<u32>>,
    /// Over all the seeds; null if one of them has no number.
    pub mean_steps: Option<f64>,
}

impl FewestSteps {
    /// The fewest steps for each of these seeds.
    pub fn new(scenario: &str, seeds: Vec<NonZeroU64>, steps: Vec<Option<u32>>) -> FewestSteps {
        let known: Option<Vec<u32>> = steps.iter().copied().collect();
        let mean_steps = known
            .filter(|known| !known.is_empty())
            .map(|known| known.iter().map(|n| f64::from(*n)).sum::<f64>() / known.len() as f64);
        FewestSteps { scenario: scenario.to_owned(), seeds, steps, mean_steps }
    }

    /// Whether they are of the very episodes of a test.
    pub fn is_of_test(&self, scenario: &str, seed: u64, episodes: u32) -> bool {
        let seeds = (0..episodes).map(|episode| episode_seed(Purpose::Test, seed, episode));
        self.scenario == scenario && self.seeds.iter().copied().eq(seeds)
    }
}
