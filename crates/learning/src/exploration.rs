//! Epsilon-greedy exploration with a decaying epsilon (eq. 4).

use serde::{Deserialize, Serialize};

/// The exponential decay of epsilon over the episodes of a training run.
///
/// # Examples
///
/// ```
/// use learning::exploration::EpsilonDecay;
///
/// let decay = EpsilonDecay { minimum: 0.1, maximum: 1.0, fraction: 0.5 };
/// assert_eq!(decay.epsilon(0, 1000), 1.0);
/// assert!((decay.epsilon(500, 1000) - 0.1165).abs() < 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpsilonDecay {
    /// The limit that epsilon approaches, 0 to 1.
    pub minimum: f64,
    /// Epsilon in the first episode, 0 to 1.
    pub maximum: f64,
    /// `P` in eq. 4: the fraction of the episodes, 0 to 1, after which 98 % of the decay is
    /// complete.
    pub fraction: f64,
}

impl EpsilonDecay {
    /// Returns epsilon, the exploration probability of an episode (eq. 4):
    /// `min + (max - min) exp(-(4 / P) e / e_total)`, where `e` is `episode`, starting at 0, and
    /// `e_total` is `episodes`.
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
    fn matches_equation_4_with_the_hyperparameters_of_the_paper() {
        assert_eq!(PAPER.epsilon(0, 1000), 1.0);
        for episode in [1, 100, 500, 999] {
            let expected = 0.1 + 0.9 * (-8.0 * f64::from(episode) / 1000.0).exp();
            assert!((PAPER.epsilon(episode, 1000) - expected).abs() < 1e-15);
        }
        // At P = 50 % of the episodes: 0.1 + 0.9 e^-4.
        assert!((PAPER.epsilon(500, 1000) - 0.116_484).abs() < 1e-6);
    }

    #[test]
    fn epsilon_decreases_and_stays_above_the_minimum() {
        for episode in 0..999 {
            let (now, next) = (PAPER.epsilon(episode, 1000), PAPER.epsilon(episode + 1, 1000));
            assert!(now > next && next > 0.1);
        }
    }
}
