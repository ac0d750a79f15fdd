//! The full-knowledge shortest paths of evaluation episodes.
//!
//! The simulator computes them, because a shortest path depends on the poses of the robot, the exit
//! and the obstacles, which the agent does not know.

use std::num::NonZeroU64;

use serde::{Deserialize, Serialize};

use crate::seeds::{Purpose, episode_seed};

/// The lengths of the full-knowledge shortest paths of several episodes.
///
/// `sim_node oracle` prints them as JSON, and `agent_node` reads them for an evaluation.
///
/// # Examples
///
/// ```
/// use task::{
///     ShortestPaths,
///     seeds::{Purpose, episode_seed},
/// };
///
/// let seeds = (0..2).map(|episode| episode_seed(Purpose::Evaluation, 1, episode)).collect();
/// let paths = ShortestPaths::new("empty", seeds, vec![Some(8), Some(9)]);
/// assert_eq!(paths.mean_steps, Some(8.5));
/// assert!(paths.matches_evaluation("empty", 1, 2));
/// assert!(!paths.matches_evaluation("concave", 1, 2));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShortestPaths {
    /// Name of the scenario used in all episodes.
    pub scenario: String,
    /// Seed of each episode.
    pub seeds: Vec<NonZeroU64>,
    /// Length of the shortest path for each seed, in steps; null if obstacles move or no path was
    /// found.
    pub steps: Vec<Option<u32>>,
    /// Mean of `steps`; null if there are no seeds or any length is null.
    pub mean_steps: Option<f64>,
}

impl ShortestPaths {
    /// Combines a scenario, its episode seeds and the length of the shortest path for each seed.
    ///
    /// `steps` has one element per seed, in the same order.
    pub fn new(scenario: &str, seeds: Vec<NonZeroU64>, steps: Vec<Option<u32>>) -> ShortestPaths {
        let known: Option<Vec<u32>> = steps.iter().copied().collect();
        let mean_steps = known
            .filter(|known| !known.is_empty())
            .map(|known| known.iter().map(|n| f64::from(*n)).sum::<f64>() / known.len() as f64);
        ShortestPaths { scenario: scenario.to_owned(), seeds, steps, mean_steps }
    }

    /// Returns whether these paths belong to an evaluation with the given scenario, seed and number
    /// of episodes.
    pub fn matches_evaluation(&self, scenario: &str, seed: u64, episodes: u32) -> bool {
        let seeds = (0..episodes).map(|episode| episode_seed(Purpose::Evaluation, seed, episode));
        self.scenario == scenario && self.seeds.iter().copied().eq(seeds)
    }
}
