//! How long the answers of a service take, from time to time.

use std::{sync::Arc, time::Duration};

use crate::report::{Level, Report};
use parking_lot::{Mutex, MutexGuard};

/// The latencies of a client; a cheap handle that can be shared.
#[derive(Clone, Debug, Default)]
pub struct Latencies {
    known: Arc<Mutex<Known>>,
}

#[derive(Debug, Default)]
struct Known {
    recent: Recent,
    /// About the median.
    usual: Option<Duration>,
}

/// By what an answer moves the [usual](Latencies::record) latency.
const STEP: f64 = 1.125;
/// An answer that takes so many times what is usual is late.
const LATE: u32 = 4;

/// The answers since somebody asked last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Recent {
    answers: u64,
    sum: Duration,
    longest: Duration,
}

impl Latencies {
    /// An answer took so long, from the request to the moment when somebody waited for it and had it.
    ///
    /// What is usual is the median, which each answer moves a little towards itself. As long as most
    /// come at once, those that had to be asked for again do not count for more.
    pub(crate) fn record(&self, latency: Duration) {
        let mut known = self.known();
        known.recent.answers += 1;
        known.recent.sum += latency;
        known.recent.longest = known.recent.longest.max(latency);
        known.usual = Some(match known.usual {
            None => latency,
            Some(median) if latency > median => median.mul_f64(STEP),
            Some(median) => median.div_f64(STEP),
        });
    }

    /// After how long an answer is so late that it was lost, if that is known yet.
    pub(crate) fn timeout(&self) -> Option<Duration> {
        self.known().usual.map(|median| LATE * median)
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock()
    }

    /// The answers since the last report.
    pub fn report(&self) -> Report {
        let Recent { answers, sum, longest } = std::mem::take(&mut self.known().recent);
        if answers == 0 {
            let message = "no answer since the last report".to_owned();
            return Report { level: Level::Stale, message, values: Vec::new() };
        }
        let microseconds = |duration: Duration| format!("{:.0}", duration.as_secs_f64() * 1e6);
        Report {
            level: Level::Ok,
            message: format!("{answers} answers since the last report"),
            values: vec![
                ("answers", answers.to_string()),
                ("mean latency, us", microseconds(sum.div_f64(answers as f64))),
                ("longest latency, us", microseconds(longest)),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_late_is_learnt_from_what_is_usual() {
        let milliseconds = Duration::from_millis;
        let latencies = Latencies::default();
        assert_eq!(latencies.timeout(), None);
        let learn = |latency, times| (0..times).for_each(|_| latencies.record(latency));
        learn(milliseconds(8), 50);
        let about = |wanted: Duration| {
            let found = latencies.timeout().unwrap();
            assert!(wanted * 3 / 4 < found && found < wanted * 4 / 3, "{found:?} {wanted:?}");
        };
        about(milliseconds(32));
        // A third of them late, as where messages are lost, changes little.
        for _ in 0..30 {
            learn(milliseconds(300), 1);
            learn(milliseconds(8), 2);
        }
        assert!(latencies.timeout().unwrap() < milliseconds(50));
        // A network that has become slow is believed, and one that has become fast again.
        learn(milliseconds(200), 60);
        about(milliseconds(800));
        learn(milliseconds(2), 60);
        about(milliseconds(8));
    }

    #[test]
    fn a_report_is_of_what_came_since_the_last_one() {
        let latencies = Latencies::default();
        latencies.record(Duration::from_micros(100));
        latencies.record(Duration::from_micros(300));
        let values = latencies.report().values;
        let expected =
            [("answers", "2"), ("mean latency, us", "200"), ("longest latency, us", "300")];
        assert_eq!(values, expected.map(|(key, value)| (key, value.to_owned())));
        assert_eq!(latencies.report().level, Level::Stale);
    }
}
