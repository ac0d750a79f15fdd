//! Plot axes with a few ticks at round numbers and a range that is never empty.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::numbers;

/// The range, the ticks and the tick labels of an axis.
///
/// Replaces the axes of plotters, which start and end exactly at the data and label 1000 as
/// "1000.0".
#[derive(Clone, Debug)]
pub(super) struct Axis {
    range: Range<f64>,
    ticks: Vec<f64>,
    logarithmic: bool,
}

impl Axis {
    /// Returns an axis from 0 to `episodes` with at most `ticks` tick intervals, each a whole
    /// number of episodes.
    pub fn of_episodes(episodes: u32, ticks: u32) -> Self {
        let end = f64::from(episodes.max(1));
        let step = round_step(end / f64::from(ticks)).max(1.0);
        let last = (end / step).floor() as u32;
        let ticks = (0..=last).map(|index| f64::from(index) * step).collect();
        Self { range: 0.0..end, ticks, logarithmic: false }
    }

    /// Returns a linear axis that covers `low..=high`, extended to the next ticks.
    pub fn linear(low: f64, high: f64) -> Self {
        let step = round_step(if high > low { (high - low) / 5.0 } else { high.abs() / 5.0 });
        // Because of rounding errors, the outermost ticks can lie slightly inside low..=high.
        let first = (low / step).floor();
        let last = (high / step).ceil().max(first + 1.0);
        let count = (last - first) as u32;
        let ticks = (0..=count).map(|index| (first + f64::from(index)) * step).collect();
        Self { range: low.min(first * step)..high.max(last * step), ticks, logarithmic: false }
    }

    /// Returns a logarithmic axis that covers `low..=high` (both positive), extended to 1, 2 or 5
    /// times a power of ten. The ticks are at these multiples, or only at powers of ten if
    /// `high / low` exceeds 300.
    pub fn logarithmic(low: f64, high: f64) -> Self {
        let powers = low.log10().floor() as i32 - 1..=high.log10().ceil() as i32 + 1;
        let round: Vec<f64> =
            powers.flat_map(|power| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(power))).collect();
        let first = round.partition_point(|tick| *tick <= low).saturating_sub(1);
        let last = round.partition_point(|tick| *tick < high).max(first + 1);
        let every = if high / low > 300.0 { 3 } else { 1 };
        // Every third element of `round` is a power of ten.
        let ticks = (first..=last).filter(|index| index % every == 0).map(|index| round[index]);
        Self { range: round[first]..round[last], ticks: ticks.collect(), logarithmic: true }
    }

    /// Returns whether a value is within the range of the axis.
    pub fn contains(&self, value: f64) -> bool {
        (self.range.start..=self.range.end).contains(&value)
    }

    /// Returns the value itself for a linear axis, or its decimal logarithm for a logarithmic axis.
    fn scaled(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let [start, value, end] =
            [self.range.start, *value, self.range.end].map(|value| self.scaled(value));
        from + (f64::from(to - from) * (value - start) / (end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // Light points are minor ticks, which these axes do not have.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, tick: &f64) -> String {
        // Enough decimals to distinguish neighbouring ticks.
        let resolution = match self.ticks[..] {
            [first, second, ..] if !self.logarithmic => second - first,
            _ => tick.abs(),
        };
        let magnitude = (resolution.log10() + 1e-9).floor();
        if magnitude < -4.0 && *tick != 0.0 {
            return format!("{tick:.0e}").replace('-', "−");
        }
        numbers::decimal(*tick, (-magnitude).clamp(0.0, 4.0) as usize)
    }
}

/// Returns the smallest number of the form 1, 2 or 5 times a power of ten that is at least `step`,
/// or 1 if `step` is not positive.
fn round_step(step: f64) -> f64 {
    if step <= 0.0 || !step.is_normal() {
        return 1.0;
    }
    let power = 10f64.powf(step.log10().floor());
    let multiple = [1.0, 2.0, 5.0].into_iter().find(|m| m * power >= step * (1.0 - 1e-9));
    power * multiple.unwrap_or(10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks.iter().map(|tick| axis.format_ext(tick)).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_cover_the_values() {
        assert_eq!(labels(&Axis::linear(-93.0, -0.8)), ["−100", "−80", "−60", "−40", "−20", "0"]);
        assert_eq!(labels(&Axis::linear(0.1, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    }

    #[test]
    fn logarithmic_axes_over_many_decades_have_ticks_only_at_powers_of_ten() {
        assert_eq!(labels(&Axis::logarithmic(5.0, 90.0)), ["5", "10", "20", "50", "100"]);
        assert_eq!(labels(&Axis::logarithmic(2.0, 10_000.0)), ["10", "100", "1,000", "10,000"]);
        assert_eq!(
            labels(&Axis::logarithmic(0.002, 0.04)),
            ["0.002", "0.005", "0.01", "0.02", "0.05"]
        );
        assert_eq!(labels(&Axis::logarithmic(1e-6, 2e-6)), ["1e−6", "2e−6"]);
    }

    #[test]
    fn episode_ticks_are_whole_numbers() {
        assert_eq!(labels(&Axis::of_episodes(1000, 10)).last().unwrap(), "1,000");
        assert_eq!(labels(&Axis::of_episodes(1, 10)), ["0", "1"]);
        assert_eq!(labels(&Axis::of_episodes(0, 10)), ["0", "1"]);
    }

    #[test]
    fn an_axis_for_a_constant_value_is_not_empty() {
        for value in [-0.1, 0.0, 0.05, 3.0, 1e6] {
            let axis = Axis::linear(value, value);
            assert!(axis.range.start < axis.range.end, "{axis:?}");
            assert!(axis.contains(value) && axis.ticks.len() < 12, "{axis:?}");
        }
        for value in [1e-9, 0.3, 10_000.0] {
            let axis = Axis::logarithmic(value, value);
            assert!(axis.range.start < axis.range.end && axis.contains(value), "{axis:?}");
        }
    }

    #[test]
    fn an_axis_contains_only_its_range() {
        assert!(!Axis::linear(0.0, 1.0).contains(1.5));
        assert!(!Axis::logarithmic(1.0, 10.0).contains(0.0));
        assert!(Axis::logarithmic(1.0, 10.0).contains(10.0));
    }

    #[test]
    fn values_are_mapped_linearly_or_logarithmically_to_pixels() {
        let pixels = |axis: &Axis, value| axis.map(&value, (500, 100));
        let linear = Axis::linear(0.0, 10.0);
        assert_eq!([0.0, 5.0, 10.0].map(|value| pixels(&linear, value)), [500, 300, 100]);
        let logarithmic = Axis::logarithmic(1.0, 100.0);
        assert_eq!([1.0, 10.0, 100.0].map(|value| pixels(&logarithmic, value)), [500, 300, 100]);
    }
}
