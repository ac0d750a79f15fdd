//! Values by episode, as points and as the line through them.

use super::moving_average::{WINDOW, moving_average};
use learning::record::EpisodeRecord;

/// What a plot shows: (episode, value) for each point.
pub(super) struct Curve {
    /// Every episode by itself; none where the line says it all.
    pub points: Vec<(f64, f64)>,
    /// The mean of the latest [`WINDOW`] episodes, or the values themselves.
    pub line: Vec<(f64, f64)>,
}

impl Curve {
    /// One value per episode that has one, and the mean of the latest.
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

    /// A quantity that needs no smoothing.
    pub fn exact(records: &[EpisodeRecord], mut value: impl FnMut(&EpisodeRecord) -> f64) -> Self {
        let line = records.iter().map(|record| (f64::from(record.episode), value(record)));
        Self { points: Vec::new(), line: line.collect() }
    }

    /// Blocked moves per 100 steps. The mean is that of the steps, not of the episodes: a short
    /// episode has fewer steps to be blocked in.
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

    /// The least and the greatest value; `None` of nothing.
    pub fn extent(&self) -> Option<(f64, f64)> {
        let values = self.points.iter().chain(&self.line).map(|(_, value)| *value);
        values.fold(None, |extent, value| match extent {
            None => Some((value, value)),
            Some((low, high)) => Some((value.min(low), value.max(high))),
        })
    }

    /// Below this lie only the worst 2 % of the points: a few endless early episodes would otherwise
    /// press all that follows into the top of the plot. The line stays above it once it has a whole
    /// window to look back on.
    pub fn floor_of_the_bulk(&self) -> Option<f64> {
        let mut values: Vec<f64> = self.points.iter().map(|(_, value)| *value).collect();
        values.sort_by(f64::total_cmp);
        let floor = *values.get(values.len() / 50)?;
        let settled = self.line.iter().skip(WINDOW - 1).map(|(_, mean)| *mean);
        Some(settled.fold(floor, f64::min))
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
    fn the_mean_of_blocked_moves_is_that_of_the_steps() {
        let curve = Curve::blocked(&[record(0, 90, 0, None), record(1, 10, 5, None)]);
        assert_eq!(curve.points, [(0.0, 0.0), (1.0, 50.0)]);
        assert_eq!(curve.line, [(0.0, 0.0), (1.0, 5.0)]);
    }

    #[test]
    fn a_few_endless_episodes_are_not_the_bulk() {
        let steps = |episode| if episode < 2 { 10_000 } else { 20 };
        let records: Vec<_> = (0..200).map(|e| record(e, steps(e), 0, None)).collect();
        let curve = Curve::averaged(&records, |record| Some(f64::from(record.episode_return)));
        let floor = curve.floor_of_the_bulk().unwrap();
        // The mean of the first whole window holds both endless episodes.
        assert!((floor - (-2.0 * 1000.0 - 48.0 * 2.0) / 50.0).abs() < 1e-3, "{floor}");
        assert_eq!(Curve::averaged(&[], |_| None).floor_of_the_bulk(), None);
    }
}
