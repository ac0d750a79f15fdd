//! A subscriber to `/diagnostics` on the simulator's host.

use std::{
    sync::{Arc, Mutex, MutexGuard},
    thread,
    time::Duration,
};

use experiments::network::Host;
use ros_interfaces::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use ros_runtime::{
    Arguments, Node,
    discovery::Discovery,
    node::{Subscription, reliable},
};

/// Values from the diagnostics received so far.
#[derive(Clone, Copy, Debug, Default)]
struct Counters {
    /// Steps that the simulator has executed.
    steps: u64,
    /// Episodes that the agent has learned from.
    episodes: u64,
    /// The longest time that the agent has waited for a step.
    longest_latency: Duration,
}

impl Counters {
    fn update(&mut self, status: &DiagnosticStatus) {
        let number = |key: &str| {
            let value = status.values.iter().find(|value| value.key == key)?;
            value.value.parse::<u64>().ok()
        };
        match status.name.as_str() {
            "sim_node: room" => self.steps = number("steps").unwrap_or(self.steps),
            "agent_node: learner" => self.episodes = number("episodes").unwrap_or(self.episodes),
            "agent_node: service /step" => {
                let longest = Duration::from_micros(number("longest latency, us").unwrap_or(0));
                self.longest_latency = self.longest_latency.max(longest);
            }
            _ => {}
        }
    }
}

/// Collects diagnostics in a background thread until the process exits.
pub struct Watcher(Arc<Mutex<Counters>>);

impl Watcher {
    /// Starts a watcher on the host of the simulator, so that the simulator's reports do not cross
    /// the unreliable network.
    ///
    /// # Errors
    ///
    /// Returns an error if the network namespace of the host cannot be opened.
    pub fn on(host: &Host, discovery: Discovery) -> anyhow::Result<Watcher> {
        let counters = Arc::new(Mutex::new(Counters::default()));
        let shared = counters.clone();
        let namespace = host.door()?;
        thread::spawn(move || -> anyhow::Result<()> {
            // Moves this thread, and the threads that DDS starts from it, to the host.
            namespace.enter()?;
            let node = Node::with_discovery(
                "soak",
                &Arguments::default(),
                evac_msgs::DEFINITIONS,
                discovery,
            )?;
            let reports: Subscription<DiagnosticArray> =
                node.create_subscription("/diagnostics", reliable(10))?;
            node.block_on(async {
                loop {
                    let (report, _) = reports.async_take().await?;
                    let mut counters = lock(&shared);
                    report.status.iter().for_each(|status| counters.update(status));
                }
            })
        });
        Ok(Watcher(counters))
    }

    /// Returns the number of steps that the simulator has executed so far.
    pub fn steps(&self) -> u64 {
        lock(&self.0).steps
    }

    /// Returns the number of episodes that the agent has learned from so far.
    pub fn episodes(&self) -> u64 {
        lock(&self.0).episodes
    }

    /// Returns the longest time that the agent has waited for a step so far.
    pub fn longest_latency(&self) -> Duration {
        lock(&self.0).longest_latency
    }
}

fn lock(counters: &Mutex<Counters>) -> MutexGuard<'_, Counters> {
    counters.lock().expect("no thread panics while it holds this lock")
}
