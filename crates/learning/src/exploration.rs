//! Exploration against exploitation: epsilon-greedy with a decaying epsilon (eq. 4).

use serde::{Deserialize, Serialize};

/// How epsilon decays over a training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpsilonDecay {
    /// The exploration probability that is approached.
    pub minimum: f64,
    /// The exploration probability of the first episode.
    pub maximum: f64,
    /// `P` of eq. 4: the share of the episodes after which epsilon is about the minimum.
    pub fraction: f64,
}

impl EpsilonDecay {
    /// Eq. 4 for episode `e`, counted from 0, of `e_total`:
    /// `min + (max - min) exp(-(4 / P) e / e_total)`.
    pub fn epsilon(&self, episode: u32, episodes: u32) -> f64 {
        let progress = f64::from(episode) / f64::from(episodes);
        self.minimum + (self.maximum - self.minimum) * libm::exp(-4.0 / self.fraction * progress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: EpsilonDecay = EpsilonDecay { minimum: 0.1, maximum: 1.0, fraction: 0.5 };

    #[test]
    fn equation_4_with_the_papers_numbers() {
        assert_eq!(PAPER.epsilon(0, 1000), 1.0);
        for episode in [1, 100, 500, 999] {
            let expected = 0.1 + 0.9 * (-8.0 * f64::from(episode) / 1000.0).exp();
            assert!((PAPER.epsilon(episode, 1000) - expected).abs() < 1e-15);
        }
        // At P = 50 % of the episodes: 0.1 + 0.9 e^-4, which is 0.1165 by hand.
        assert!((PAPER.epsilon(500, 1000) - 0.116_484).abs() < 1e-6);
    }

    #[test]
    fn epsilon_falls_and_stays_within_its_limits() {
        for episode in 0..999 {
            let (now, next) = (PAPER.epsilon(episode, 1000), PAPER.epsilon(episode + 1, 1000));
            assert!(now > next && next > 0.1);
        }
    }
}
