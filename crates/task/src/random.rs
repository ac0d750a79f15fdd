//! Random numbers that are identical on every machine and with every version of the dependencies.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of random numbers that depends only on its key.
///
/// The words come from ChaCha8. This type converts them to numbers itself, because the range and
/// distribution types of the `rand` crates may return different values in different versions. The
/// logarithm and cosine in `std` differ in their last bits between platforms, so this type uses
/// those in libm.
///
/// # Examples
///
/// ```
/// use task::Random;
///
/// let mut random = Random::from_key([7, 0, 0, 0]);
/// let mut same = random.clone();
/// assert_eq!(random.normal(1.0).to_bits(), same.normal(1.0).to_bits());
/// assert!((0.0..1.0).contains(&random.uniform()));
/// assert!(random.below(6) < 6);
///
/// let position = random.position();
/// let word = random.word();
/// random.set_position(position);
/// assert_eq!(random.word(), word);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Random(ChaCha8Rng);

impl Random {
    /// Returns the ChaCha8 stream with the given key, as four little-endian words, and nonce 0.
    pub fn from_key(key: [u64; 4]) -> Random {
        let mut bytes = [0; 32];
        for (bytes, word) in bytes.chunks_exact_mut(8).zip(key) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        Random(ChaCha8Rng::from_seed(bytes))
    }

    /// Selects another stream with the same key; `stream` is the ChaCha nonce.
    pub fn with_stream(mut self, stream: u64) -> Random {
        self.0.set_stream(stream);
        self
    }

    /// Returns the next 64-bit word.
    pub fn word(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Returns a uniformly distributed number in `[0, 1)`, made from the upper 53 bits of a word
    /// (the precision of `f64`).
    pub fn uniform(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1u64 << 53) as f64;
        (self.word() >> 11) as f64 * STEP
    }

    /// Returns a uniformly distributed number in `[-half_width, half_width)`.
    pub fn within(&mut self, half_width: f64) -> f64 {
        (2.0 * self.uniform() - 1.0) * half_width
    }

    /// Returns a uniformly distributed integer in `0..count`, or 0 if `count` is 0.
    ///
    /// The relative bias of each value is at most about `count / 2^53`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.uniform() * count as f64) as usize
    }

    /// Returns true with the given probability, 0 to 1.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    /// Returns a normally distributed number with mean 0 and the given standard deviation.
    ///
    /// Uses the cosine half of the Box-Muller transform and consumes two words.
    pub fn normal(&mut self, deviation: f64) -> f64 {
        // 1 - uniform() is in (0, 1], so the logarithm is finite.
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        deviation * radius * libm::cos(TAU * self.uniform())
    }

    /// Returns the position in the stream, in 32-bit words from its start.
    pub fn position(&self) -> u128 {
        self.0.get_word_pos()
    }

    /// Moves the stream to a position returned by [`position`](Self::position).
    pub fn set_position(&mut self, position: u128) {
        self.0.set_word_pos(position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The expected words come from an independent Python implementation of ChaCha.
    #[test]
    fn words_match_chacha8_with_the_same_key() {
        let mut random = Random::from_key([1, 0, 0, 0]);
        let words: Vec<u64> = (0..3).map(|_| random.word()).collect();
        assert_eq!(words, [7037237572835827407, 5440448899038119230, 14725191807199933458]);
    }

    #[test]
    fn numbers_match_the_golden_values() {
        let mut random = Random::from_key([1, 0, 0, 0]);
        let numbers = [random.uniform(), random.normal(1.0), random.within(3.0)];
        assert_eq!(numbers.map(f64::to_bits), GOLDEN);
    }

    const GOLDEN: [u64; 3] = [4600543922235128406, 4598160950249148205, 4612804981256062329];

    #[test]
    fn normal_has_the_moments_of_a_normal_distribution() {
        let mut random = Random::from_key([7, 0, 0, 0]);
        let count = 200_000;
        let draws: Vec<f64> = (0..count).map(|_| random.normal(1.0)).collect();
        let mean = draws.iter().sum::<f64>() / f64::from(count);
        let moment =
            |power| draws.iter().map(|x| libm::pow(*x, power)).sum::<f64>() / f64::from(count);
        assert!(mean.abs() < 0.01, "mean {mean}");
        assert!((moment(2.0) - 1.0).abs() < 0.012, "variance {}", moment(2.0));
        // A normal distribution has kurtosis 3: its fourth moment is 3 sigma^4.
        assert!((moment(4.0) - 3.0).abs() < 0.1, "fourth moment {}", moment(4.0));
    }

    #[test]
    fn below_is_uniform() {
        let mut random = Random::from_key([3, 0, 0, 0]);
        let mut counts = [0; 4];
        for _ in 0..40_000 {
            counts[random.below(4)] += 1;
        }
        assert!(counts.iter().all(|count| (9_600..10_400).contains(count)), "{counts:?}");
    }

    #[test]
    fn a_stream_resumes_from_a_saved_position() {
        let mut random = Random::from_key([1, 2, 3, 4]).with_stream(5);
        random.normal(1.0);
        let position = random.position();
        let next = random.word();
        let mut again = Random::from_key([1, 2, 3, 4]).with_stream(5);
        again.set_position(position);
        assert_eq!(again.word(), next);
    }
}
