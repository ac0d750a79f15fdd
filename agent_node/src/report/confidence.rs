//! How far a success rate of so many episodes can be trusted.

/// The two-sided 95 % quantile of the standard normal distribution.
const Z: f64 = 1.959_964;

/// Wilson's 95 % score interval of a share (Wilson 1927), `None` without trials.
///
/// Unlike the textbook's `p ± z sqrt(p (1 - p) / n)` it stays within 0 and 1, and says something
/// when every trial succeeded, which is the usual case here.
pub(super) fn wilson_interval(successes: u32, trials: u32) -> Option<(f64, f64)> {
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
    fn it_is_one_sided_at_the_ends() {
        let (low, high) = wilson_interval(1000, 1000).unwrap();
        assert!((low - 0.99617).abs() < 1e-5);
        assert_eq!(high, 1.0);
        assert_eq!(wilson_interval(0, 20).unwrap().0, 0.0);
        assert_eq!(wilson_interval(0, 0), None);
    }
}
