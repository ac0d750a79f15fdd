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
