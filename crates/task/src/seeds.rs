//! The seed and scenario of each episode in a run.
//!
//! The seed of a run determines all of its randomness: every reset carries an episode seed, which
//! is a hash of the purpose of the run, its seed and the episode index. With moving obstacles, this
//! deviates from the paper, where a reset leaves the obstacles where they are.

use std::num::NonZeroU64;

use crate::{Random, Scenario};

/// The scenario name for a run that draws a random scenario for each episode.
pub const MIXED: &str = "mixed";

/// The purpose of an episode.
///
/// Training and evaluation episodes have different seeds, barring a hash collision (probability
/// 2^-64 per pair).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The agent learns and explores.
    Training,
    /// The trained policy is evaluated without exploration.
    Evaluation,
}

/// Returns the seed of the episode with the given index, starting at 0.
///
/// The seed is never 0, because a reset with seed 0 continues the simulator's own random state.
///
/// # Examples
///
/// ```
/// use task::seeds::{Purpose, episode_seed};
///
/// let seed = episode_seed(Purpose::Training, 0, 0);
/// assert_eq!(seed.get(), 4_606_029_925_845_525_861);
/// assert_ne!(seed, episode_seed(Purpose::Evaluation, 0, 0));
/// ```
pub fn episode_seed(purpose: Purpose, run_seed: u64, episode: u32) -> NonZeroU64 {
    let mut random = episode_random(purpose, run_seed, episode);
    loop {
        if let Some(seed) = NonZeroU64::new(random.word()) {
            return seed;
        }
    }
}

/// Returns the scenario of the episode with the given index: the scenario of the run or, if that is
/// [`MIXED`], a scenario drawn uniformly from [`Scenario::ALL`].
///
/// # Examples
///
/// ```
/// use task::{
///     Scenario,
///     seeds::{MIXED, Purpose, episode_scenario},
/// };
///
/// assert_eq!(episode_scenario("concave", Purpose::Training, 0, 7), "concave");
/// let drawn = episode_scenario(MIXED, Purpose::Training, 0, 7);
/// assert!(drawn.parse::<Scenario>().is_ok());
/// ```
pub fn episode_scenario(run_scenario: &str, purpose: Purpose, run_seed: u64, episode: u32) -> &str {
    match run_scenario {
        MIXED => {
            // A separate stream keeps the scenario independent of the episode's seed.
            let mut random = episode_random(purpose, run_seed, episode).with_stream(1);
            Scenario::ALL[random.below(Scenario::ALL.len())].name()
        }
        scenario => scenario,
    }
}

/// Returns the ChaCha8 stream whose key consists of the run seed, the purpose and the episode.
/// Streams with different keys are independent, so the first word serves as a hash of the key.
///
/// The second word of the key distinguishes the uses of a seed: 1 and 2 here, 3 in the learner, 0
/// in the simulator.
fn episode_random(purpose: Purpose, run_seed: u64, episode: u32) -> Random {
    let domain = match purpose {
        Purpose::Training => 1,
        Purpose::Evaluation => 2,
    };
    Random::from_key([run_seed, domain, u64::from(episode), 0])
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn episode_seeds_are_distinct() {
        let mut seeds = HashSet::new();
        for run_seed in 0..10 {
            for episode in 0..1000 {
                for purpose in [Purpose::Training, Purpose::Evaluation] {
                    assert!(seeds.insert(episode_seed(purpose, run_seed, episode)));
                }
            }
        }
    }

    #[test]
    fn episode_seeds_match_the_golden_values() {
        assert_eq!(episode_seed(Purpose::Training, 0, 0).get(), GOLDEN[0]);
        assert_eq!(episode_seed(Purpose::Evaluation, 1, 999).get(), GOLDEN[1]);
    }

    const GOLDEN: [u64; 2] = [4_606_029_925_845_525_861, 10_211_153_073_896_380_468];

    #[test]
    fn a_mixed_run_draws_scenarios_uniformly_and_reproducibly() {
        let episodes = 1000 * Scenario::ALL.len() as u32;
        let scenario = |episode| episode_scenario(MIXED, Purpose::Training, 3, episode);
        let scenarios: Vec<&str> = (0..episodes).map(scenario).collect();
        for name in Scenario::ALL.map(Scenario::name) {
            let count = scenarios.iter().filter(|scenario| **scenario == name).count();
            assert!((880..1120).contains(&count), "{name}: {count}");
        }
        assert!((0..episodes).map(scenario).eq(scenarios.iter().copied()));
        let evaluation = |episode| episode_scenario(MIXED, Purpose::Evaluation, 3, episode);
        assert!(!(0..episodes).map(evaluation).eq(scenarios));
        assert_eq!(episode_scenario("concave", Purpose::Training, 3, 7), "concave");
    }
}
