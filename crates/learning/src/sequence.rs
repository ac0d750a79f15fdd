//! The random sequences of the learner, from the seed of the run.

use task::Random;

/// What is drawn from a random sequence. Each has one of its own, so that drawing from one never changes
/// another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// The initial weights.
    Weights,
    /// Exploration: whether, and which action.
    Exploration,
    /// The batches drawn from the replay memory.
    Replay,
}

impl Sequence {
    /// The sequence of a run.
    pub fn random(self, run_seed: u64) -> Random {
        /// Besides those of [`task::seeds`].
        const DOMAIN: u64 = 3;
        let number = match self {
            Sequence::Weights => 0,
            Sequence::Exploration => 1,
            Sequence::Replay => 2,
        };
        Random::from_key([run_seed, DOMAIN, number, 0])
    }
}
