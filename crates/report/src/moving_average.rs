//! The heavier line of a learning curve.

/// Episodes that one point of the average looks back on.
pub(super) const WINDOW: usize = 50;

/// The mean of each value and those before it, `window` of them at most.
///
/// It looks back only, so a point never knows about episodes that came later; the first points are
/// means of what there is.
pub(super) fn moving_average(values: &[f64], window: usize) -> Vec<f64> {
    // Summed afresh at every point: a running sum would carry its rounding errors along.
    (1..=values.len())
        .map(|end| &values[end.saturating_sub(window.max(1))..end])
        .map(|latest| latest.iter().sum::<f64>() / latest.len() as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_looks_back_over_the_window_and_no_further() {
        assert_eq!(moving_average(&[1.0, 3.0, 5.0, 100.0], 2), [1.0, 2.0, 4.0, 52.5]);
    }

    #[test]
    fn a_window_longer_than_the_run_takes_what_there_is() {
        assert_eq!(moving_average(&[2.0, 4.0, 9.0], WINDOW), [2.0, 3.0, 5.0]);
    }

    #[test]
    fn nothing_has_no_average() {
        assert!(moving_average(&[], WINDOW).is_empty());
    }
}
