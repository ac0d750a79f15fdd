//! Number formats for the report.
//!
//! # Examples
//!
//! ```
//! use report::numbers::{count, decimal, duration, percent};
//!
//! assert_eq!(count(51_316), "51,316");
//! assert_eq!(decimal(-1234.56, 1), "−1,234.6");
//! assert_eq!(percent(0.943), "94.3\u{a0}%");
//! assert_eq!(duration(1142.0), "19:02");
//! ```

/// Placeholder for a number that is not finite.
const MISSING: &str = "–";

/// Formats a count with thousands separators: `51316` as "51,316".
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// Formats a number with thousands separators and a fixed number of decimals: `-1234.56` with one
/// decimal as "−1,234.6". Returns a dash if the number is not finite.
pub fn decimal(number: f64, decimals: usize) -> String {
    if !number.is_finite() {
        return MISSING.into();
    }
    let rounded = format!("{:.decimals$}", number.abs());
    let (whole, fraction) = rounded.split_at(rounded.find('.').unwrap_or(rounded.len()));
    let whole = whole.parse().map_or_else(|_| whole.to_owned(), count);
    // A number that rounds to zero has no sign.
    let sign = if number < 0.0 && rounded.contains(|digit| matches!(digit, '1'..='9')) {
        "−"
    } else {
        ""
    };
    format!("{sign}{whole}{fraction}")
}

/// Formats a share as a percentage with a non-breaking space: `0.943` as "94.3 %". Only exactly 1
/// is formatted as "100 %" and only exactly 0 as "0 %", so that one failure in a million is
/// visible.
pub fn percent(share: f64) -> String {
    if share == 0.0 || share == 1.0 {
        return format!("{}\u{a0}%", 100.0 * share);
    }
    let shown = if (0.0..1.0).contains(&share) { share.clamp(0.001, 0.999) } else { share };
    format!("{}\u{a0}%", decimal(100.0 * shown, 1))
}

/// Formats a duration in seconds as "19:02" or "1:02:03". Returns a dash if the duration is
/// negative or not finite.
pub fn duration(seconds: f64) -> String {
    if !(seconds.is_finite() && seconds >= 0.0) {
        return MISSING.into();
    }
    let seconds = seconds.round() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if hours > 0 {
        format!("{}:{minutes:02}:{seconds:02}", count(hours))
    } else {
        format!("{minutes}:{seconds:02}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_grouped_by_thousands() {
        let shown = [0, 999, 1_000, 51_316, 1_234_567].map(count);
        assert_eq!(shown, ["0", "999", "1,000", "51,316", "1,234,567"]);
    }

    #[test]
    fn decimals_are_rounded_grouped_and_signed() {
        assert_eq!(decimal(51_316.04, 1), "51,316.0");
        assert_eq!(decimal(-1234.56, 1), "−1,234.6");
        assert_eq!(decimal(-0.01, 1), "0.0");
        assert_eq!(decimal(11.0, 0), "11");
        assert_eq!(decimal(f64::NAN, 1), "–");
    }

    #[test]
    fn only_exact_shares_are_0_or_100_percent() {
        assert_eq!(percent(0.943), "94.3\u{a0}%");
        assert_eq!(percent(1.0), "100\u{a0}%");
        assert_eq!(percent(0.9999), "99.9\u{a0}%");
        assert_eq!(percent(0.0001), "0.1\u{a0}%");
        assert_eq!(percent(0.0), "0\u{a0}%");
        assert_eq!(percent(f64::NAN), "–\u{a0}%");
    }

    #[test]
    fn durations_are_minutes_or_hours() {
        let shown = [0.0, 5.4, 1142.0, 3723.0, f64::NAN].map(duration);
        assert_eq!(shown, ["0:00", "0:05", "19:02", "1:02:03", "–"]);
    }
}
