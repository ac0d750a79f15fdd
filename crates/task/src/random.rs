//! Random numbers that are the same on every machine and with every version of every dependency.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of random numbers that is a function of its key.
///
/// ChaCha is specified, and so is the way from its words to the numbers here: ranges and
/// distributions of crates may change their values from one version to the next, and take logarithms
/// and exponentials from `std`, whose last bits depend on the platform. Here they come from libm.
///
/// ```
/// use task::Random;
///
/// let (mut one, mut same) = (Random::from_key([7, 0, 0, 0]), Random::from_key([7, 0, 0, 0]));
/// assert_eq!(one.normal(1.0).to_bits(), same.normal(1.0).to_bits());
/// assert!((0.0..1.0).contains(&one.uniform()) && one.below(6) < 6);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Random(ChaCha8Rng);

impl Random {
    /// The stream of ChaCha8 with this key, the words in little-endian order, and the nonce 0.
    pub fn from_key(key: [u64; 4]) -> Random {
        let mut bytes = [0; 32];
        for (bytes, word) in bytes.chunks_exact_mut(8).zip(key) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        Random(ChaCha8Rng::from_seed(bytes))
    }

    /// Another stream with the same key: `stream` is ChaCha's nonce.
    pub fn with_stream(mut self, stream: u64) -> Random {
        self.0.set_stream(stream);
        self
    }

    /// Uniform among all numbers of 64 bits.
    pub fn word(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1): the upper 53 bits of a word, as many as a double holds.
    pub fn uniform(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1u64 << 53) as f64;
        (self.word() >> 11) as f64 * STEP
    }

    /// Uniform in [-half_width, half_width).
    pub fn within(&mut self, half_width: f64) -> f64 {
        (2.0 * self.uniform() - 1.0) * half_width
    }

    /// Uniform in 0..count. The chance of a number is within `count / 2^53` of `1 / count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.uniform() * count as f64) as usize
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    /// Normally distributed with mean 0 and this deviation: the cosine half of the Box-Muller
    /// transform, from two words.
    pub fn normal(&mut self, deviation: f64) -> f64 {
        // 1 - [0, 1) is never 0, whose logarithm is infinite.
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        deviation * radius * libm::cos(TAU * self.uniform())
    }

    /// Where the stream is, in words of 32 bits.
    pub fn position(&self) -> u128 {
        self.0.get_word_pos()
    }

    /// Goes to a [`position`](Self::position).
    pub fn set_position(&mut self, position: u128) {
        self.0.set_word_pos(position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words are those of an implementation in Python, written from the definition of ChaCha.
    #[test]
    fn a_key_is_the_key_of_chacha8() {
        let mut random = Random::from_key([1, 0, 0, 0]);
        let words: Vec<u64> = (0..3).map(|_| random.word()).collect();
        assert_eq!(words, [7037237572835827407, 5440448899038119230, 14725191807199933458]);
    }

    #[test]
    fn numbers_are_the_same_for_ever() {
        let mut random = Random::from_key([1, 0, 0, 0]);
        let numbers = [random.uniform(), random.normal(1.0), random.within(3.0)];
        assert_eq!(numbers.map(f64::to_bits), GOLDEN);
    }

    const GOLDEN: [u64; 3] = [4600543922235128406, 4598160950249148205, 4612804981256062329];

    #[test]
    fn normal_has_the_moments_of_its_distribution() {
        let mut random = Random::from_key([7, 0, 0, 0]);
        let count = 200_000;
        let draws: Vec<f64> = (0..count).map(|_| random.normal(1.0)).collect();
        let mean = draws.iter().sum::<f64>() / f64::from(count);
        let moment =
            |power| draws.iter().map(|x| libm::pow(*x, power)).sum::<f64>() / f64::from(count);
        assert!(mean.abs() < 0.01, "mean {mean}");
        assert!((moment(2.0) - 1.0).abs() < 0.012, "variance {}", moment(2.0));
        // Kurtosis 3: the fourth moment is 3 sigma^4.
        assert!((moment(4.0) - 3.0).abs() < 0.1, "fourth moment {}", moment(4.0));
    }

    #[test]
    fn below_reaches_every_value_equally() {
        let mut random = Random::from_key([3, 0, 0, 0]);
        let mut counts = [0; 4];
        for _ in 0..40_000 {
            counts[random.below(4)] += 1;
        }
        assert!(counts.iter().all(|count| (9_600..10_400).contains(count)), "{counts:?}");
    }

    #[test]
    fn a_stream_goes_on_from_its_position() {
        let mut random = Random::from_key([1, 2, 3, 4]).with_stream(5);
        random.normal(1.0);
        let position = random.position();
        let next = random.word();
        let mut again = Random::from_key([1, 2, 3, 4]).with_stream(5);
        again.set_position(position);
        assert_eq!(again.word(), next);
    }
}
