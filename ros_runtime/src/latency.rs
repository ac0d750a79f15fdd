//! How long the answers of a service take, from time to time.

use std::{
    sync::{Arc, Mutex},
    time::Duration,
};

use crate::diagnostics::{Level, Report};

/// The latencies of a client; a cheap handle that can be shared.
#[derive(Clone, Debug, Default)]
pub struct Latencies {
    recent: Arc<Mutex<Recent>>,
    usual: Arc<Mutex<Option<Usual>>>,
}

/// How long an answer usually takes: a mean and a mean deviation, of which the latest answers count
/// most, as TCP has them for its retransmissions (RFC 6298).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Usual {
    mean: Duration,
    deviation: Duration,
}

/// The answers since somebody asked last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Recent {
    answers: u32,
    sum: Duration,
    longest: Duration,
}

impl Latencies {
    /// An answer took so long.
    pub(crate) fn record(&self, latency: Duration) {
        let mut recent = self.recent.lock().expect("nothing panics while it holds this lock");
        recent.answers += 1;
        recent.sum += latency;
        recent.longest = recent.longest.max(latency);
    }

    /// Learns from a request that was answered without being repeated.
    pub(crate) fn learn(&self, latency: Duration) {
        let mut usual = self.usual.lock().expect("nothing panics while it holds this lock");
        *usual = Some(match *usual {
            None => Usual { mean: latency, deviation: latency / 2 },
            Some(Usual { mean, deviation }) => Usual {
                mean: mean * 7 / 8 + latency / 8,
                deviation: deviation * 3 / 4 + latency.abs_diff(mean) / 4,
            },
        });
    }

    /// After how long an answer is so late that it was lost, if that is known yet.
    pub(crate) fn timeout(&self) -> Option<Duration> {
        let usual = *self.usual.lock().expect("nothing panics while it holds this lock");
        usual.map(|Usual { mean, deviation }| mean + 4 * deviation)
    }

    /// The answers since the last report.
    pub fn report(&self) -> Report {
        let mut recent = self.recent.lock().expect("nothing panics while it holds this lock");
        let Recent { answers, sum, longest } = std::mem::take(&mut *recent);
        if answers == 0 {
            let message = "no answer in the last second".to_owned();
            return Report { level: Level::Stale, message, values: Vec::new() };
        }
        let microseconds = |duration: Duration| format!("{:.0}", duration.as_secs_f64() * 1e6);
        Report {
            level: Level::Ok,
            message: format!("{answers} answers in the last second"),
            values: vec![
                ("answers", answers.to_string()),
                ("mean latency, us", microseconds(sum / answers)),
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
        latencies.learn(milliseconds(8));
        assert_eq!(latencies.timeout(), Some(milliseconds(24)));
        // The steadier, the sooner; a network that has become slow is believed soon.
        (0..50).for_each(|_| latencies.learn(milliseconds(8)));
        assert!(latencies.timeout().unwrap() < milliseconds(9));
        (0..20).for_each(|_| latencies.learn(milliseconds(200)));
        assert!(latencies.timeout().unwrap() > milliseconds(200));
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
