//! Diagnostics: publishes the status of a node's components on `/diagnostics` once a second
//! (REP-107).
//!
//! Each component has a function that returns its report. The function is called only while the
//! topic has subscribers.

use std::{sync::Arc, time::Duration};

use parking_lot::{Mutex, MutexGuard};
use ros_interfaces::{
    diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue},
    std_msgs::Header,
};
use tokio::time::{MissedTickBehavior, interval};

pub use crate::report::{Level, Report};
use crate::{clock::Clock, publisher::Publisher};

/// The interval between reports, 1 s.
pub const PERIOD: Duration = Duration::from_secs(1);

type Component = (String, Box<dyn FnMut() -> Report + Send>);

/// The components of a node. Clones share them.
///
/// # Examples
///
/// ```
/// use ros_runtime::diagnostics::{Diagnostics, Level, Report};
///
/// // In a node: `node.diagnostics()`.
/// let diagnostics = Diagnostics::default();
/// diagnostics.add("battery", || Report {
///     level: Level::Warn,
///     message: "battery low".to_owned(),
///     values: vec![("voltage, V", "10.9".to_owned())],
/// });
/// ```
#[derive(Clone, Default)]
pub struct Diagnostics {
    components: Arc<Mutex<Vec<Component>>>,
}

impl Diagnostics {
    /// Adds a component with a name, such as `camera`, and a function that returns its report.
    ///
    /// The status is named `NODE: NAME`. The function runs on the node's background thread once a
    /// second while `/diagnostics` has subscribers. It must not block or call `add`.
    pub fn add(&self, name: &str, report: impl FnMut() -> Report + Send + 'static) {
        self.components().push((name.to_owned(), Box::new(report)));
    }

    /// Publishes reports until the task is dropped.
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
                status: self.components().iter_mut().map(|each| status(&node, each)).collect(),
            });
        }
    }

    fn components(&self) -> MutexGuard<'_, Vec<Component>> {
        self.components.lock()
    }
}

fn status(node: &str, (component, report): &mut Component) -> DiagnosticStatus {
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
        name: format!("{node}: {component}"),
        message,
        hardware_id: String::new(),
        values: values.collect(),
    }
}
