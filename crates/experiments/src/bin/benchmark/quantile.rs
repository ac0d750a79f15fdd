//! Quantiles of measurements.

/// Returns the quantile `share` (0 to 1) of `values`, which it sorts.
pub fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}

/// Returns the median of `values`, which it sorts.
pub fn median(values: &mut [f64]) -> f64 {
    percentile(values, 0.5)
}
