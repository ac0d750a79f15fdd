//! The moving average of a learning curve.

/// Length of the averaging window, in episodes.
pub(super) const WINDOW: usize = 50;

/// Returns, for each value, the mean of that value and the values before it, over at most `window`
/// values.
///
/// The average is trailing: later values do not affect a point. The first `window - 1` points
/// average fewer values.
pub(super) fn moving_average(values: &[f64], window: usize) -> Vec<f64> {
    // Each window is summed from scratch, because a running sum would accumulate rounding errors.
    (1..=values.len())
        .map(|end| &values[end.saturating_sub(window.max(1))..end])
        .map(|values| values.iter().sum::<f64>() / values.len() as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_the_trailing_window() {
        assert_eq!(moving_average(&[1.0, 3.0, 5.0, 100.0], 2), [1.0, 2.0, 4.0, 52.5]);
    }

    #[test]
    fn a_window_longer_than_the_data_averages_all_previous_values() {
        assert_eq!(moving_average(&[2.0, 4.0, 9.0], WINDOW), [2.0, 3.0, 5.0]);
    }

    #[test]
    fn the_moving_average_of_no_values_is_empty() {
        assert!(moving_average(&[], WINDOW).is_empty());
    }
}
