//! Numbers as people read them.

/// Stands where there is no number.
const NOTHING: &str = "–";

/// `51316` as "51,316".
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

/// `-1234.56` with one decimal as "−1,234.6"; a dash for what is not a number.
pub fn decimal(number: f64, decimals: usize) -> String {
    if !number.is_finite() {
        return NOTHING.into();
    }
    let rounded = format!("{:.decimals$}", number.abs());
    let (whole, fraction) = rounded.split_at(rounded.find('.').unwrap_or(rounded.len()));
    let whole = whole.parse().map_or_else(|_| whole.to_owned(), count);
    // What rounds to zero has no sign.
    let sign = if number < 0.0 && rounded.contains(|digit| matches!(digit, '1'..='9')) {
        "−"
    } else {
        ""
    };
    format!("{sign}{whole}{fraction}")
}

/// `0.943` as "94.3 %". Only all is "100 %" and only nothing is "0 %": one failure in a million shows.
pub fn percent(share: f64) -> String {
    if share == 0.0 || share == 1.0 {
        return format!("{}\u{a0}%", 100.0 * share);
    }
    let shown = if (0.0..1.0).contains(&share) { share.clamp(0.001, 0.999) } else { share };
    format!("{}\u{a0}%", decimal(100.0 * shown, 1))
}

/// Seconds as "19:02" or "1:02:03".
pub fn duration(seconds: f64) -> String {
    if !(seconds.is_finite() && seconds >= 0.0) {
        return NOTHING.into();
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
    fn only_all_is_a_hundred_percent() {
        assert_eq!(percent(0.943), "94.3\u{a0}%");
        assert_eq!(percent(1.0), "100\u{a0}%");
        assert_eq!(percent(0.9999), "99.9\u{a0}%");
        assert_eq!(percent(0.0001), "0.1\u{a0}%");
        assert_eq!(percent(0.0), "0\u{a0}%");
        assert_eq!(percent(f64::NAN), "–\u{a0}%");
    }

    #[test]
    fn durations_read_like_a_clock() {
        let shown = [0.0, 5.4, 1142.0, 3723.0, f64::NAN].map(duration);
        assert_eq!(shown, ["0:00", "0:05", "19:02", "1:02:03", "–"]);
    }
}
