//! Confidence intervals for success rates and for means over seeds.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The 97.5 % quantile of the standard normal distribution, for two-sided 95 % intervals.
const Z: f64 = 1.959_964;

/// Returns the 95 % score interval (low, high) of a success rate (Wilson 1927), or `None` if there
/// are no trials. Both ends are between 0 and 1.
///
/// Unlike the normal approximation `p ± z sqrt(p (1 - p) / n)`, this interval stays within 0 to 1
/// and does not collapse to a point if every trial succeeds, which is the usual case here.
///
/// # Examples
///
/// ```
/// use report::confidence::wilson_interval;
///
/// let (low, high) = wilson_interval(943, 1000).unwrap();
/// assert!((low - 0.927).abs() < 1e-3 && (high - 0.956).abs() < 1e-3);
/// assert_eq!(wilson_interval(0, 0), None);
/// ```
pub fn wilson_interval(successes: u32, trials: u32) -> Option<(f64, f64)> {
    if trials == 0 {
        return None;
    }
    let n = f64::from(trials);
    let p = f64::from(successes) / n;
    let scale = 1.0 + Z * Z / n;
    let centre = (p + Z * Z / (2.0 * n)) / scale;
    let half_width = Z / scale * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    // Avoids rounding errors: the low end is exactly 0 if no trial succeeds, and the high end is
    // exactly 1 if all succeed.
    let low = if successes == 0 { 0.0 } else { centre - half_width };
    let high = if successes >= trials { 1.0 } else { centre + half_width };
    Some((low, high))
}

/// A mean over seeds with its confidence interval.
///
/// # Examples
///
/// ```
/// use report::confidence::Mean;
///
/// let mean = Mean::of(&[11.2, 11.6, 11.4]).unwrap();
/// let (low, high) = mean.interval.unwrap();
/// assert!(low < mean.mean && mean.mean < high);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// 95 % confidence interval (low, high), from Student's t-distribution; `None` for a single
    /// seed.
    pub interval: Option<(f64, f64)>,
}

impl Mean {
    /// Returns the mean of `values`, one per seed, or `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Mean> {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let freedom = count - 1.0;
        // The distribution, and therefore the interval, requires at least one degree of freedom.
        let interval = StudentsT::new(0.0, 1.0, freedom).ok().map(|distribution| {
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            let error = (squares / freedom / count).sqrt();
            let half_width = distribution.inverse_cdf(0.975) * error;
            (mean - half_width, mean + half_width)
        });
        (!values.is_empty()).then_some(Mean { mean, interval })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_intervals_agree_with_published_values() {
        // Newcombe 1998, table I, method 3: 81 of 263, and 15 of 148.
        for (successes, trials, low, high) in [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605)]
        {
            let interval = wilson_interval(successes, trials).unwrap();
            assert!((interval.0 - low).abs() < 5e-5 && (interval.1 - high).abs() < 5e-5);
        }
    }

    #[test]
    fn the_interval_of_a_mean_is_based_on_the_t_distribution() {
        // With four degrees of freedom, the 97.5 % quantile is 2.776445. The standard error is
        // 0.707107.
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        let (low, high) = mean.interval.unwrap();
        assert!((low - 1.036_757).abs() < 1e-5 && (high - 4.963_243).abs() < 1e-5, "{mean:?}");
        assert_eq!(Mean::of(&[3.0]), Some(Mean { mean: 3.0, interval: None }));
        assert_eq!(Mean::of(&[]), None);
    }

    #[test]
    fn wilson_intervals_end_exactly_at_0_and_1() {
        let (low, high) = wilson_interval(1000, 1000).unwrap();
        assert!((low - 0.99617).abs() < 1e-5);
        assert_eq!(high, 1.0);
        assert_eq!(wilson_interval(0, 20).unwrap().0, 0.0);
        assert_eq!(wilson_interval(0, 0), None);
    }
}
