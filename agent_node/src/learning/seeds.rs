//! The seed of every episode and of every random sequence, from the seed of the run.
//!
//! A run is a function of its seed: each reset carries a seed of its own, a hash of the run's
//! purpose, its seed and the episode. Where obstacles move this departs from the paper, which lets
//! them wander on across resets.

use std::num::NonZeroU64;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What an episode is for. Training and test never share a seed but by a chance of 2^-64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Purpose {
    /// The agent learns.
    Training,
    /// The agent is tested.
    Test,
}

/// A random sequence of the learner. Each has a stream of its own, so that drawing from one never
/// changes another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sequence {
    /// The initial weights.
    Weights,
    /// Exploration: whether, and which action.
    Exploration,
    /// The batches drawn from the replay memory.
    Replay,
}

/// The seed of an episode; never 0, which would mean "none" to the simulator.
pub fn episode_seed(purpose: Purpose, run_seed: u64, episode: u32) -> NonZeroU64 {
    let mut generator = generator(run_seed, domain_of(purpose), u64::from(episode));
    loop {
        if let Some(seed) = NonZeroU64::new(generator.next_u64()) {
            return seed;
        }
    }
}

/// The generator of what else an episode is about; it has nothing to do with the episode's seed.
pub fn episode_generator(purpose: Purpose, run_seed: u64, episode: u32) -> ChaCha8Rng {
    let mut generator = generator(run_seed, domain_of(purpose), u64::from(episode));
    generator.set_stream(1);
    generator
}

fn domain_of(purpose: Purpose) -> u64 {
    match purpose {
        Purpose::Training => 1,
        Purpose::Test => 2,
    }
}

/// The generator of one of the learner's sequences.
pub fn sequence(run_seed: u64, sequence: Sequence) -> ChaCha8Rng {
    let stream = match sequence {
        Sequence::Weights => 0,
        Sequence::Exploration => 1,
        Sequence::Replay => 2,
    };
    generator(run_seed, 0, stream)
}

/// ChaCha's key is the hash's input: what it makes of different keys is unrelated.
fn generator(run_seed: u64, domain: u64, index: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    for (bytes, word) in key.chunks_exact_mut(8).zip([run_seed, domain, index]) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    ChaCha8Rng::from_seed(key)
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
}
