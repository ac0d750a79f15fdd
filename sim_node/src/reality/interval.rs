//! Intervals of values that are drawn once per episode.

use task::Random;

/// An interval from which a value is drawn uniformly at the start of each episode.
///
/// # Examples
///
/// ```
/// use sim_node::reality::Interval;
///
/// assert_eq!(Interval::from_list(&[0.5]), Ok(Interval::around_zero(0.5)));
/// assert_eq!(Interval::from_list(&[0.8, 1.25]), Ok(Interval::between(0.8, 1.25)));
/// assert!(Interval::from_list(&[1.0, 0.5]).is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    low: f64,
    high: f64,
}

/// The error for a list of numbers that is not an interval.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum IntervalError {
    /// The list has an invalid length. Holds the length.
    #[error("invalid length {0} (expected: [r] for -r to r, or [low, high])")]
    Length(usize),
    /// The single number is negative or not a number. Holds it.
    #[error("invalid half width {0} (expected: a finite number >= 0)")]
    HalfWidth(f64),
    /// The limits are in the wrong order, or one is not finite. Holds them.
    #[error("invalid limits {0} and {1} (expected: finite numbers, the lower limit first)")]
    Order(f64, f64),
}

impl Interval {
    /// Returns the interval from `-half_width` to `half_width`, which must not be negative.
    pub const fn around_zero(half_width: f64) -> Interval {
        Interval { low: -half_width, high: half_width }
    }

    /// Returns the interval from `low` to `high`, which must not be less than `low`.
    pub const fn between(low: f64, high: f64) -> Interval {
        Interval { low, high }
    }

    /// Returns the interval that contains only `value`.
    pub const fn only(value: f64) -> Interval {
        Interval { low: value, high: value }
    }

    /// Parses a list: `[r]` is the interval from -r to r, `[low, high]` that from low to high.
    ///
    /// # Errors
    ///
    /// Returns an error if the list has another length or does not describe an interval.
    pub fn from_list(list: &[f64]) -> Result<Interval, IntervalError> {
        match *list {
            [half_width] if (0.0..f64::INFINITY).contains(&half_width) => {
                Ok(Interval::around_zero(half_width))
            }
            [half_width] => Err(IntervalError::HalfWidth(half_width)),
            [low, high] if low <= high && (high - low).is_finite() => Ok(Interval { low, high }),
            [low, high] => Err(IntervalError::Order(low, high)),
            _ => Err(IntervalError::Length(list.len())),
        }
    }

    /// Returns the shortest list that describes the interval.
    pub fn to_list(self) -> Vec<f64> {
        if self.low == -self.high { vec![self.high] } else { vec![self.low, self.high] }
    }

    /// Returns the lower limit.
    pub fn low(self) -> f64 {
        self.low
    }

    /// Returns the upper limit.
    pub fn high(self) -> f64 {
        self.high
    }

    /// Returns a uniformly distributed value; exactly the limit if both limits are equal.
    pub(super) fn draw(self, random: &mut Random) -> f64 {
        self.low + (self.high - self.low) * random.uniform()
    }
}
