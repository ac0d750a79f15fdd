//! `/diagnostics`: how the parts of a node are, once a second (REP-107).
//!
//! A part is a function that is called when its report is due, and only while somebody reads the
//! topic: it costs nothing otherwise.

use std::{sync::Arc, time::Duration};

use parking_lot::{Mutex, MutexGuard};
use ros_interfaces::{
    diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue},
    std_msgs::Header,
};
use tokio::time::{MissedTickBehavior, interval};

pub use crate::report::{Level, Report};
use crate::{clock::Clock, publisher::Publisher};

/// The time between two reports of a part.
pub const PERIOD: Duration = Duration::from_secs(1);

type Part = (String, Box<dyn FnMut() -> Report + Send>);

/// The parts of a node; a cheap handle that can be shared.
#[derive(Clone, Default)]
pub struct Diagnostics {
    parts: Arc<Mutex<Vec<Part>>>,
}

impl Diagnostics {
    /// Adds a part, such as `camera`, which is asked for its report from now on.
    pub fn add(&self, name: &str, report: impl FnMut() -> Report + Send + 'static) {
        self.parts().push((name.to_owned(), Box::new(report)));
    }

    /// Publishes the reports for ever.
    pub(crate) async fn serve(
        self,
        node: String,
        clock: Clock,
        publisher: Publisher<DiagnosticArray>,
    ) {
        let mut ticks = interval(PERIOD);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            ticks.tick().await;
            publisher.publish_with(|| DiagnosticArray {
                header: Header { stamp: clock.now(), ..Header::default() },
                status: self.parts().iter_mut().map(|part| status(&node, part)).collect(),
            });
        }
    }

    fn parts(&self) -> MutexGuard<'_, Vec<Part>> {
        self.parts.lock()
    }
}

fn status(node: &str, (part, report): &mut Part) -> DiagnosticStatus {
    let Report { level, message, values } = report();
    let level = match level {
        Level::Ok => DiagnosticStatus::OK,
        Level::Warn => DiagnosticStatus::WARN,
        Level::Error => DiagnosticStatus::ERROR,
        Level::Stale => DiagnosticStatus::STALE,
    };
    let values = values.into_iter().map(|(key, value)| KeyValue { key: key.to_owned(), value });
    DiagnosticStatus {
        level,
        name: format!("{node}: {part}"),
        message,
        hardware_id: String::new(),
        values: values.collect(),
    }
}
