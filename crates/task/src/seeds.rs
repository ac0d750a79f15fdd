//! The seed and the scenario of every episode, from the seed of the run.
//!
//! A run is a function of its seed: each reset carries a seed of its own, a hash of the run's
//! purpose, its seed and the episode. Where obstacles move this departs from the paper, which lets
//! them wander on across resets.

use std::num::NonZeroU64;

use crate::{Random, Scenario};

/// The name of a run whose episodes take place in all scenarios: one is drawn anew for each.
pub const MIXED: &str = "mixed";

/// What an episode is for. Training and test never share a seed but by a chance of 2^-64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The agent learns.
    Training,
    /// The agent is tested.
    Test,
}

/// The seed of an episode; never 0, which would mean "none" to the simulator.
pub fn episode_seed(purpose: Purpose, run_seed: u64, episode: u32) -> NonZeroU64 {
    let mut random = episode_random(purpose, run_seed, episode);
    loop {
        if let Some(seed) = NonZeroU64::new(random.word()) {
            return seed;
        }
    }
}

/// The scenario of an episode: that of the run, or the one that is drawn where it is [`MIXED`].
pub fn episode_scenario(run_scenario: &str, purpose: Purpose, run_seed: u64, episode: u32) -> &str {
    match run_scenario {
        MIXED => {
            // It has nothing to do with the episode's seed.
            let mut random = episode_random(purpose, run_seed, episode).with_stream(1);
            Scenario::ALL[random.below(Scenario::ALL.len())].name()
        }
        scenario => scenario,
    }
}

/// ChaCha's key is the hash's input: what it makes of different keys is unrelated. Keys with a second
/// word of 0 are the learner's own.
fn episode_random(purpose: Purpose, run_seed: u64, episode: u32) -> Random {
    let domain = match purpose {
        Purpose::Training => 1,
        Purpose::Test => 2,
    };
    Random::from_key([run_seed, domain, u64::from(episode), 0])
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn no_seed_twice() {
        let mut seeds = HashSet::new();
        for run_seed in 0..10 {
            for episode in 0..1000 {
                for purpose in [Purpose::Training, Purpose::Test] {
                    assert!(seeds.insert(episode_seed(purpose, run_seed, episode)));
                }
            }
        }
    }

    #[test]
    fn the_seeds_are_the_same_for_ever() {
        assert_eq!(episode_seed(Purpose::Training, 0, 0).get(), GOLDEN[0]);
        assert_eq!(episode_seed(Purpose::Test, 1, 999).get(), GOLDEN[1]);
    }

    const GOLDEN: [u64; 2] = [4_606_029_925_845_525_861, 10_211_153_073_896_380_468];

    #[test]
    fn a_mixed_run_visits_all_scenarios_alike_and_always_in_the_same_order() {
        let episodes = 1000 * Scenario::ALL.len() as u32;
        let scenario = |episode| episode_scenario(MIXED, Purpose::Training, 3, episode);
        let scenarios: Vec<&str> = (0..episodes).map(scenario).collect();
        for name in Scenario::ALL.map(Scenario::name) {
            let count = scenarios.iter().filter(|scenario| **scenario == name).count();
            assert!((880..1120).contains(&count), "{name}: {count}");
        }
        assert!((0..episodes).map(scenario).eq(scenarios.iter().copied()));
        let test = |episode| episode_scenario(MIXED, Purpose::Test, 3, episode);
        assert!(!(0..episodes).map(test).eq(scenarios));
        assert_eq!(episode_scenario("concave", Purpose::Training, 3, 7), "concave");
    }
}
