//! Response times of a service.

use std::{sync::Arc, time::Duration};

use crate::report::{Level, Report};
use parking_lot::{Mutex, MutexGuard};

/// The latencies of a service client, from each request to its response. Clones share them.
///
/// # Examples
///
/// ```
/// use ros_runtime::{diagnostics::Level, latency::Latencies};
///
/// // In a node: `client.latencies().clone()`.
/// let latencies = Latencies::default();
/// assert_eq!(latencies.report().level, Level::Stale);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Latencies {
    statistics: Arc<Mutex<Statistics>>,
}

#[derive(Debug, Default)]
struct Statistics {
    recent: Recent,
    /// An estimate of the median; `None` before the first response.
    median: Option<Duration>,
}

/// The factor by which each response changes the estimate of the median.
const STEP: f64 = 1.125;
/// The timeout for a response, in multiples of the median.
const TIMEOUT_MEDIANS: u32 = 4;

/// The responses since the last report.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Recent {
    responses: u64,
    sum: Duration,
    longest: Duration,
}

impl Latencies {
    /// Records a latency, measured from the request until the caller received the response.
    ///
    /// Each response moves the estimate of the median by one step towards its latency. The
    /// median is robust: as long as most requests succeed at the first attempt, retries hardly
    /// change it.
    pub(crate) fn record(&self, latency: Duration) {
        let mut statistics = self.lock();
        statistics.recent.responses += 1;
        statistics.recent.sum += latency;
        statistics.recent.longest = statistics.recent.longest.max(latency);
        statistics.median = Some(match statistics.median {
            None => latency,
            Some(median) if latency > median => median.mul_f64(STEP),
            Some(median) => median.div_f64(STEP),
        });
    }

    /// Returns the time after which a response counts as lost; `None` before the first response.
    pub(crate) fn timeout(&self) -> Option<Duration> {
        self.lock().median.map(|median| TIMEOUT_MEDIANS * median)
    }

    fn lock(&self) -> MutexGuard<'_, Statistics> {
        self.statistics.lock()
    }

    /// Returns a report on the responses since the last report: their number, and their mean and
    /// longest latency in microseconds. Without responses, the level is [`Level::Stale`].
    pub fn report(&self) -> Report {
        let Recent { responses, sum, longest } = std::mem::take(&mut self.lock().recent);
        if responses == 0 {
            let message = "no response since the last report".to_owned();
            return Report { level: Level::Stale, message, values: Vec::new() };
        }
        let microseconds = |duration: Duration| format!("{:.0}", duration.as_secs_f64() * 1e6);
        Report {
            level: Level::Ok,
            message: format!("{responses} responses since the last report"),
            values: vec![
                ("responses", responses.to_string()),
                ("mean latency, us", microseconds(sum.div_f64(responses as f64))),
                ("longest latency, us", microseconds(longest)),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_timeout_follows_the_median_latency() {
        let milliseconds = Duration::from_millis;
        let latencies = Latencies::default();
        assert_eq!(latencies.timeout(), None);
        let record = |latency, times| (0..times).for_each(|_| latencies.record(latency));
        record(milliseconds(8), 50);
        let assert_about = |expected: Duration| {
            let found = latencies.timeout().unwrap();
            let is_near = expected * 3 / 4 < found && found < expected * 4 / 3;
            assert!(is_near, "{found:?}, expected about {expected:?}");
        };
        assert_about(milliseconds(32));
        // A third of the responses are late, as on a lossy network: the timeout hardly changes.
        for _ in 0..30 {
            record(milliseconds(300), 1);
            record(milliseconds(8), 2);
        }
        assert!(latencies.timeout().unwrap() < milliseconds(50));
        // The network becomes slow, then fast again.
        record(milliseconds(200), 60);
        assert_about(milliseconds(800));
        record(milliseconds(2), 60);
        assert_about(milliseconds(8));
    }

    #[test]
    fn a_report_covers_the_responses_since_the_last_one() {
        let latencies = Latencies::default();
        latencies.record(Duration::from_micros(100));
        latencies.record(Duration::from_micros(300));
        let values = latencies.report().values;
        let expected =
            [("responses", "2"), ("mean latency, us", "200"), ("longest latency, us", "300")];
        assert_eq!(values, expected.map(|(key, value)| (key, value.to_owned())));
        assert_eq!(latencies.report().level, Level::Stale);
    }
}
