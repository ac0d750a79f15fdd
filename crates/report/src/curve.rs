//! Values per episode, as points and as a line.

use super::moving_average::{WINDOW, moving_average};
use learning::record::EpisodeRecord;

/// The data of a plot, as (episode, value) pairs.
pub(super) struct Curve {
    /// One point per episode; empty if the line alone shows all values.
    pub points: Vec<(f64, f64)>,
    /// The moving average over [`WINDOW`] episodes, or the values themselves.
    pub line: Vec<(f64, f64)>,
}

impl Curve {
    /// Returns a curve with a point for each episode that has a value, and the moving average of
    /// these values as the line.
    pub fn averaged(
        records: &[EpisodeRecord],
        value: impl Fn(&EpisodeRecord) -> Option<f64>,
    ) -> Self {
        let (episodes, values): (Vec<_>, Vec<_>) = records
            .iter()
            .filter_map(|record| Some((f64::from(record.episode), value(record)?)))
            .unzip();
        let line = episodes.iter().copied().zip(moving_average(&values, WINDOW)).collect();
        Self { points: episodes.into_iter().zip(values).collect(), line }
    }

    /// Returns a curve with only a line, for a value that does not need smoothing.
    pub fn exact(records: &[EpisodeRecord], mut value: impl FnMut(&EpisodeRecord) -> f64) -> Self {
        let line = records.iter().map(|record| (f64::from(record.episode), value(record)));
        Self { points: Vec::new(), line: line.collect() }
    }

    /// Returns the curve of blocked moves per 100 steps. The moving average is weighted by steps:
    /// blocked moves divided by steps, both over the same window of episodes.
    pub fn blocked(records: &[EpisodeRecord]) -> Self {
        let blocked = Self::averaged(records, |record| Some(f64::from(record.blocked)));
        let steps = Self::averaged(records, |record| Some(f64::from(record.steps.max(1))));
        let per_100 = |blocked: Vec<(f64, f64)>, steps: Vec<(f64, f64)>| {
            let pairs = blocked.into_iter().zip(steps);
            pairs.map(|((episode, blocked), (_, steps))| (episode, 100.0 * blocked / steps))
        };
        Self {
            points: per_100(blocked.points, steps.points).collect(),
            line: per_100(blocked.line, steps.line).collect(),
        }
    }

    /// Returns the smallest and the largest value, or `None` if there are no values.
    pub fn extent(&self) -> Option<(f64, f64)> {
        let values = self.points.iter().chain(&self.line).map(|(_, value)| *value);
        values.fold(None, |extent, value| match extent {
            None => Some((value, value)),
            Some((low, high)) => Some((value.min(low), value.max(high))),
        })
    }

    /// Returns the lower limit of the y axis: the 2 % quantile of the points, or the minimum of the
    /// line from its first full window on if that is lower. Returns `None` if there are no points.
    ///
    /// Without this limit, a few very long early episodes would squeeze all others into the top of
    /// the plot.
    pub fn lower_limit(&self) -> Option<f64> {
        let mut values: Vec<f64> = self.points.iter().map(|(_, value)| *value).collect();
        values.sort_by(f64::total_cmp);
        let quantile = *values.get(values.len() / 50)?;
        let full_windows = self.line.iter().skip(WINDOW - 1).map(|(_, mean)| *mean);
        Some(full_windows.fold(quantile, f64::min))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(episode: u32, steps: u32, blocked: u32, loss: Option<f64>) -> EpisodeRecord {
        let episode_return = -0.1 * steps as f32;
        EpisodeRecord {
            episode,
            steps,
            episode_return,
            epsilon: 1.0,
            loss,
            blocked,
            terminated: true,
        }
    }

    #[test]
    fn episodes_without_a_value_leave_a_gap() {
        let losses = [None, Some(4.0), None, Some(2.0)];
        let records: Vec<_> = (0..).zip(losses).map(|(e, loss)| record(e, 1, 0, loss)).collect();
        let curve = Curve::averaged(&records, |record| record.loss);
        assert_eq!(curve.points, [(1.0, 4.0), (3.0, 2.0)]);
        assert_eq!(curve.line, [(1.0, 4.0), (3.0, 3.0)]);
    }

    #[test]
    fn the_average_of_blocked_moves_is_weighted_by_steps() {
        let curve = Curve::blocked(&[record(0, 90, 0, None), record(1, 10, 5, None)]);
        assert_eq!(curve.points, [(0.0, 0.0), (1.0, 50.0)]);
        assert_eq!(curve.line, [(0.0, 0.0), (1.0, 5.0)]);
    }

    #[test]
    fn a_few_long_episodes_do_not_set_the_lower_limit() {
        let steps = |episode| if episode < 2 { 10_000 } else { 20 };
        let records: Vec<_> = (0..200).map(|e| record(e, steps(e), 0, None)).collect();
        let curve = Curve::averaged(&records, |record| Some(f64::from(record.episode_return)));
        let limit = curve.lower_limit().unwrap();
        // The first full window contains both long episodes.
        assert!((limit - (-2.0 * 1000.0 - 48.0 * 2.0) / 50.0).abs() < 1e-3, "{limit}");
        assert_eq!(Curve::averaged(&[], |_| None).lower_limit(), None);
    }
}
