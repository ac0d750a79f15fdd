//! The random sequences of the learner, which are derived from the seed of the run.
//!
//! # Examples
//!
//! ```
//! use learning::sequence::Sequence;
//!
//! let seed = 1;
//! assert_eq!(Sequence::Replay.random(seed), Sequence::Replay.random(seed));
//! assert_ne!(Sequence::Replay.random(seed), Sequence::Exploration.random(seed));
//! ```

use task::Random;

/// The purpose of a random sequence.
///
/// Each purpose has its own sequence, so that draws for one purpose never affect those for another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// The initial weights.
    Weights,
    /// Exploration: whether to explore, and the random action.
    Exploration,
    /// The batches sampled from the replay memory, and their augmentations.
    Replay,
}

impl Sequence {
    /// Returns this sequence, positioned at its start, for a run with the given seed.
    pub fn random(self, run_seed: u64) -> Random {
        // This value differs from the domains in `task::seeds`, so the sequences are independent of
        // the episode seeds.
        const DOMAIN: u64 = 3;
        let number = match self {
            Sequence::Weights => 0,
            Sequence::Exploration => 1,
            Sequence::Replay => 2,
        };
        Random::from_key([run_seed, DOMAIN, number, 0])
    }
}
