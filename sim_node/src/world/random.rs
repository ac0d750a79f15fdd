//! Everything random in the room.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of random numbers that is a function of its seed for ever.
///
/// ChaCha is specified, and so is the way from its words to the numbers here: the crates' own
/// `seed_from_u64`, ranges and distributions may change their values from one version to the
/// next, and the normal distribution of `rand_distr` takes its logarithm and exponential from
/// `std`, whose last bits depend on the platform.
#[derive(Debug, Clone)]
pub(super) struct Random(ChaCha8Rng);

impl Random {
    /// The stream whose ChaCha8 key is the seed's eight bytes, little-endian, then zeros.
    pub(super) fn from_seed(seed: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        Self(ChaCha8Rng::from_seed(key))
    }

    /// Uniform in [0, 1): the upper 53 bits of a word, as many as a double holds.
    fn unit(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * STEP
    }

    /// Uniform in [-half_width, half_width).
    pub(super) fn within(&mut self, half_width: f64) -> f64 {
        (2.0 * self.unit() - 1.0) * half_width
    }

    /// Uniform in 0..count; `count` is small, so that rounding favours nobody.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// A uniform heading, in radians.
    pub(super) fn heading(&mut self) -> f64 {
        self.within(TAU / 2.0)
    }

    /// Normally distributed around 0: the cosine half of the Box-Muller transform, from two words.
    pub(super) fn normal(&mut self, deviation: f64) -> f64 {
        // 1 - [0, 1) is never 0, whose logarithm is infinite.
        let radius = (-2.0 * libm::log(1.0 - self.unit())).sqrt();
        deviation * radius * libm::cos(TAU * self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words are those of an implementation in Python, written from the definition of ChaCha.
    #[test]
    fn a_seed_is_the_key_of_chacha8() {
        let mut random = Random::from_seed(1);
        let words: Vec<u64> = (0..3).map(|_| random.0.next_u64()).collect();
        assert_eq!(words, [7037237572835827407, 5440448899038119230, 14725191807199933458]);
    }

    #[test]
    fn normal_has_the_moments_of_its_deviation() {
        let mut random = Random::from_seed(7);
        let count = 200_000;
        let draws: Vec<f64> = (0..count).map(|_| random.normal(0.5)).collect();
        let mean = draws.iter().sum::<f64>() / count as f64;
        let moment = |power: usize| {
            draws
                .iter()
                .map(|draw| [draw; 4][..power].iter().copied().product::<f64>())
                .sum::<f64>()
                / count as f64
        };
        assert!(mean.abs() < 0.005, "mean {mean}");
        assert!((moment(2) - 0.25).abs() < 0.003, "variance {}", moment(2));
        // Kurtosis 3: the fourth moment is 3 sigma^4.
        assert!((moment(4) - 0.1875).abs() < 0.006, "fourth moment {}", moment(4));
    }

    #[test]
    fn below_reaches_every_value_equally() {
        let mut random = Random::from_seed(3);
        let mut counts = [0; 4];
        for _ in 0..40_000 {
            counts[random.below(4)] += 1;
        }
        assert!(counts.iter().all(|count| (9_600..10_400).contains(count)), "{counts:?}");
    }
}
