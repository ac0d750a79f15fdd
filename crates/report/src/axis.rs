//! An axis that people can read: round ticks, few of them, and never an empty range.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::numbers;

/// The extent and the ticks of one axis, and how it is labelled.
///
/// plotters' own axes begin and end where the data do, and label 1000 as "1000.0".
#[derive(Clone, Debug)]
pub(super) struct Axis {
    range: Range<f64>,
    ticks: Vec<f64>,
    logarithmic: bool,
}

impl Axis {
    /// From 0 to `episodes`, with a tick every so many whole episodes, `ticks` of them at most.
    pub fn of_episodes(episodes: u32, ticks: u32) -> Self {
        let end = f64::from(episodes.max(1));
        let step = round_step(end / f64::from(ticks)).max(1.0);
        let last = (end / step).floor() as u32;
        let ticks = (0..=last).map(|index| f64::from(index) * step).collect();
        Self { range: 0.0..end, ticks, logarithmic: false }
    }

    /// Holds `low..=high`, extended to whole ticks.
    pub fn linear(low: f64, high: f64) -> Self {
        let step = round_step(if high > low { (high - low) / 5.0 } else { high.abs() / 5.0 });
        // Rounding may leave the outermost ticks a hair inside of the values.
        let first = (low / step).floor();
        let last = (high / step).ceil().max(first + 1.0);
        let count = (last - first) as u32;
        let ticks = (0..=count).map(|index| (first + f64::from(index)) * step).collect();
        Self { range: low.min(first * step)..high.max(last * step), ticks, logarithmic: false }
    }

    /// Holds `low..=high`, which are positive, extended to 1, 2 or 5 times a power of ten; these are
    /// its ticks too, or only the powers where there are many.
    pub fn logarithmic(low: f64, high: f64) -> Self {
        let powers = low.log10().floor() as i32 - 1..=high.log10().ceil() as i32 + 1;
        let round: Vec<f64> =
            powers.flat_map(|power| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(power))).collect();
        let first = round.partition_point(|tick| *tick <= low).saturating_sub(1);
        let last = round.partition_point(|tick| *tick < high).max(first + 1);
        let every = if high / low > 300.0 { 3 } else { 1 };
        // The multiples come in threes, a power of ten first.
        let ticks = (first..=last).filter(|index| index % every == 0).map(|index| round[index]);
        Self { range: round[first]..round[last], ticks: ticks.collect(), logarithmic: true }
    }

    /// Whether a value lies on the axis.
    pub fn holds(&self, value: f64) -> bool {
        (self.range.start..=self.range.end).contains(&value)
    }

    /// A value as a length along the axis, in a unit of the axis's own.
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
        // Light points are a finer grid between the ticks; these axes have none.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, tick: &f64) -> String {
        // As many decimals as tell one tick from the next.
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

/// The smallest of 1, 2 and 5 times a power of ten that is not below `step`; 1 for no step at all.
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
    fn linear_ticks_are_round_and_hold_the_values() {
        assert_eq!(labels(&Axis::linear(-93.0, -0.8)), ["−100", "−80", "−60", "−40", "−20", "0"]);
        assert_eq!(labels(&Axis::linear(0.1, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    }

    #[test]
    fn logarithmic_ticks_thin_out_over_many_decades() {
        assert_eq!(labels(&Axis::logarithmic(5.0, 90.0)), ["5", "10", "20", "50", "100"]);
        assert_eq!(labels(&Axis::logarithmic(2.0, 10_000.0)), ["10", "100", "1,000", "10,000"]);
        assert_eq!(
            labels(&Axis::logarithmic(0.002, 0.04)),
            ["0.002", "0.005", "0.01", "0.02", "0.05"]
        );
        assert_eq!(labels(&Axis::logarithmic(1e-6, 2e-6)), ["1e−6", "2e−6"]);
    }

    #[test]
    fn episodes_have_whole_ticks() {
        assert_eq!(labels(&Axis::of_episodes(1000, 10)).last().unwrap(), "1,000");
        assert_eq!(labels(&Axis::of_episodes(1, 10)), ["0", "1"]);
        assert_eq!(labels(&Axis::of_episodes(0, 10)), ["0", "1"]);
    }

    #[test]
    fn a_constant_value_has_an_axis() {
        for value in [-0.1, 0.0, 0.05, 3.0, 1e6] {
            let axis = Axis::linear(value, value);
            assert!(axis.range.start < axis.range.end, "{axis:?}");
            assert!(axis.holds(value) && axis.ticks.len() < 12, "{axis:?}");
        }
        for value in [1e-9, 0.3, 10_000.0] {
            let axis = Axis::logarithmic(value, value);
            assert!(axis.range.start < axis.range.end && axis.holds(value), "{axis:?}");
        }
    }

    #[test]
    fn an_axis_holds_what_lies_on_it() {
        assert!(!Axis::linear(0.0, 1.0).holds(1.5));
        assert!(!Axis::logarithmic(1.0, 10.0).holds(0.0));
        assert!(Axis::logarithmic(1.0, 10.0).holds(10.0));
    }

    #[test]
    fn values_are_drawn_in_proportion() {
        let pixels = |axis: &Axis, value| axis.map(&value, (500, 100));
        let linear = Axis::linear(0.0, 10.0);
        assert_eq!([0.0, 5.0, 10.0].map(|value| pixels(&linear, value)), [500, 300, 100]);
        let logarithmic = Axis::logarithmic(1.0, 100.0);
        assert_eq!([1.0, 10.0, 100.0].map(|value| pixels(&logarithmic, value)), [500, 300, 100]);
    }
}
