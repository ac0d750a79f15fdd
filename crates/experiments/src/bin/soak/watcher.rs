//! Somebody on the simulator's host who reads `/diagnostics`.

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

/// What the nodes have said of themselves so far.
#[derive(Clone, Copy, Debug, Default)]
struct Said {
    /// Steps that the simulator has executed.
    steps: u64,
    /// Episodes that the agent has learnt from.
    episodes: u64,
    /// The longest that the agent has waited for a step.
    longest_latency: Duration,
}

/// Reads until its process ends.
pub struct Watcher(Arc<Mutex<Said>>);

impl Watcher {
    /// Reads on a host: what that one says is not lost on the way.
    pub fn on(host: &Host, discovery: Discovery) -> anyhow::Result<Watcher> {
        let said = Arc::new(Mutex::new(Said::default()));
        let shared = said.clone();
        let door = host.door()?;
        thread::spawn(move || -> anyhow::Result<()> {
            // For this thread and those that DDS starts from it.
            door.enter()?;
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
                    report.status.iter().for_each(|status| hear(status, &mut lock(&shared)));
                }
            })
        });
        Ok(Watcher(said))
    }

    /// Steps that the simulator has executed so far.
    pub fn steps(&self) -> u64 {
        lock(&self.0).steps
    }

    /// Episodes that the agent has learnt from so far.
    pub fn episodes(&self) -> u64 {
        lock(&self.0).episodes
    }

    /// The longest that the agent has waited for a step so far.
    pub fn longest_latency(&self) -> Duration {
        lock(&self.0).longest_latency
    }
}

fn lock(said: &Mutex<Said>) -> MutexGuard<'_, Said> {
    said.lock().expect("nothing panics while it holds this lock")
}

fn hear(status: &DiagnosticStatus, said: &mut Said) {
    let number = |key: &str| {
        let value = status.values.iter().find(|value| value.key == key)?;
        value.value.parse::<u64>().ok()
    };
    match status.name.as_str() {
        "sim_node: room" => said.steps = number("steps").unwrap_or(said.steps),
        "agent_node: learner" => said.episodes = number("episodes").unwrap_or(said.episodes),
        "agent_node: service /step" => {
            let longest = Duration::from_micros(number("longest latency, us").unwrap_or(0));
            said.longest_latency = said.longest_latency.max(longest);
        }
        _ => {}
    }
}
