//! How far a success rate of so many episodes, or a mean over so many seeds, can be trusted.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The two-sided 95 % quantile of the standard normal distribution.
const Z: f64 = 1.959_964;

/// Wilson's 95 % score interval of a share (Wilson 1927), `None` without trials.
///
/// Unlike the textbook's `p ± z sqrt(p (1 - p) / n)` it stays within 0 and 1, and says something
/// when every trial succeeded, which is the usual case here.
pub fn wilson_interval(successes: u32, trials: u32) -> Option<(f64, f64)> {
    if trials == 0 {
        return None;
    }
    let n = f64::from(trials);
    let p = f64::from(successes) / n;
    let scale = 1.0 + Z * Z / n;
    let centre = (p + Z * Z / (2.0 * n)) / scale;
    let half_width = Z / scale * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    // The ends are exact where nothing or everything succeeded; rounding must not blur them.
    let low = if successes == 0 { 0.0 } else { centre - half_width };
    let high = if successes >= trials { 1.0 } else { centre + half_width };
    Some((low, high))
}

/// A mean over seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// Student's 95 % confidence interval; none of a single seed.
    pub interval: Option<(f64, f64)>,
}

impl Mean {
    /// `None` without values.
    pub fn of(values: &[f64]) -> Option<Mean> {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let freedom = count - 1.0;
        // Without a degree of freedom there is no distribution, and no interval.
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
    fn it_agrees_with_published_values() {
        // Newcombe 1998, table I, method 3: 81 of 263, and 15 of 148.
        for (successes, trials, low, high) in [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605)]
        {
            let interval = wilson_interval(successes, trials).unwrap();
            assert!((interval.0 - low).abs() < 5e-5 && (interval.1 - high).abs() < 5e-5);
        }
    }

    #[test]
    fn a_mean_has_students_interval() {
        // The quantile for four degrees of freedom is 2.776445; the standard error here is 0.707107.
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        let (low, high) = mean.interval.unwrap();
        assert!((low - 1.036_757).abs() < 1e-5 && (high - 4.963_243).abs() < 1e-5, "{mean:?}");
        assert_eq!(Mean::of(&[3.0]), Some(Mean { mean: 3.0, interval: None }));
        assert_eq!(Mean::of(&[]), None);
    }

    #[test]
    fn it_is_one_sided_at_the_ends() {
        let (low, high) = wilson_interval(1000, 1000).unwrap();
        assert!((low - 0.99617).abs() < 1e-5);
        assert_eq!(high, 1.0);
        assert_eq!(wilson_interval(0, 20).unwrap().0, 0.0);
        assert_eq!(wilson_interval(0, 0), None);
    }
}
