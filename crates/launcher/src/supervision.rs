//! Keeps simulators alive, runs an agent beside them, and ends all when it ends.

use std::{
    future,
    os::unix::process::ExitStatusExt,
    path::PathBuf,
    process::{ExitCode, ExitStatus},
    time::{Duration, Instant},
};

use futures::{StreamExt, stream::FuturesUnordered};
use tokio::{
    signal::unix::{Signal, SignalKind, signal},
    time::sleep,
};

use crate::{children::Node, readiness::Readiness};

/// A simulator that has failed is started again after this time.
const PAUSE: Duration = Duration::from_secs(1);
/// One that ends sooner after its start than this has failed to start.
const SHORT_LIFE: Duration = Duration::from_secs(10);
/// The number of consecutive failures to start after which it is given up.
const MOST_FAILURES: u32 = 10;
/// How often an agent that has failed is started again.
const MOST_RESTARTS: u32 = 3;
/// The exit code of a panic.
const PANIC: i32 = 101;
/// SIGABRT: for want of memory, or a panic outside of Rust's hands.
const ABORT: i32 = 6;

/// Which nodes to run.
pub struct Plan {
    /// The program of the simulator, and the arguments of each; none for a robot.
    pub simulator: PathBuf,
    /// The arguments of each simulator.
    pub simulators: Vec<Vec<String>>,
    /// The program of the agent.
    pub agent: PathBuf,
    /// Its arguments.
    pub agent_arguments: Vec<String>,
    /// Where a training has its checkpoints, if this is one: an agent that has failed goes on from there.
    pub checkpoint: Option<PathBuf>,
}

/// Why this process is to end.
struct Signals {
    interrupt: Signal,
    terminate: Signal,
    hang_up: Signal,
}

impl Signals {
    fn new() -> std::io::Result<Signals> {
        Ok(Signals {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hang_up: signal(SignalKind::hangup())?,
        })
    }

    async fn any(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
            _ = self.hang_up.recv() => {}
        }
    }
}

/// A simulator, and how often it has failed.
struct Simulator<'a> {
    plan: &'a Plan,
    readiness: &'a Readiness,
    arguments: &'a [String],
    node: Node,
    started: Instant,
    failures: u32,
}

impl<'a> Simulator<'a> {
    fn start(
        plan: &'a Plan,
        arguments: &'a [String],
        readiness: &'a Readiness,
    ) -> anyhow::Result<Simulator<'a>> {
        let node = Node::start(&plan.simulator, arguments, readiness)?;
        Ok(Simulator { plan, readiness, arguments, node, started: Instant::now(), failures: 0 })
    }

    /// Keeps it alive; returns once it is given up.
    async fn watch(&mut self) -> anyhow::Error {
        loop {
            match self.start_again().await {
                Ok(()) => {}
                Err(given_up) => return given_up,
            }
        }
    }

    /// Waits until it ends, and starts it again.
    async fn start_again(&mut self) -> anyhow::Result<()> {
        let status = self.node.wait().await?;
        if self.started.elapsed() >= SHORT_LIFE {
            self.failures = 0;
        }
        self.failures += 1;
        if self.failures == MOST_FAILURES {
            anyhow::bail!(
                "sim_node has ended {MOST_FAILURES} times in a row, the last time with {status}"
            );
        }
        eprintln!("evac: sim_node has ended with {status}; it is started again");
        sleep(PAUSE).await;
        self.node = Node::start(&self.plan.simulator, self.arguments, self.readiness)?;
        self.started = Instant::now();
        Ok(())
    }
}

/// Runs the nodes until the agent ends, which gives the exit code.
pub async fn run(plan: &Plan) -> anyhow::Result<ExitCode> {
    let readiness = Readiness::listen()?;
    let mut simulators = Vec::new();
    for arguments in &plan.simulators {
        simulators.push(Simulator::start(plan, arguments, &readiness)?);
    }
    let outcome = run_agent(plan, &readiness, &mut simulators).await;
    for simulator in &simulators {
        simulator.node.terminate();
    }
    for simulator in &mut simulators {
        let _ = simulator.node.end().await;
    }
    outcome
}

/// Runs the agent, as soon as the simulators are ready, and again if it fails.
async fn run_agent(
    plan: &Plan,
    readiness: &Readiness,
    simulators: &mut [Simulator<'_>],
) -> anyhow::Result<ExitCode> {
    let mut signals = Signals::new()?;
    tokio::select! {
        () = readiness.of(simulators.len()) => {}
        given_up = any_given_up(simulators) => return Err(given_up),
        () = signals.any() => return Ok(ExitCode::SUCCESS),
    }
    let mut arguments = plan.agent_arguments.clone();
    for restarts in 0.. {
        let mut agent = Node::start(&plan.agent, &arguments, readiness)?;
        let status = tokio::select! {
            status = agent.wait() => status?,
            given_up = any_given_up(simulators) => {
                let _ = agent.end().await;
                return Err(given_up);
            }
            () = signals.any() => return Ok(code(agent.end().await?)),
        };
        // What an agent says to be an error would be one again.
        let failed = status.code() == Some(PANIC) || status.signal() == Some(ABORT);
        if !failed || restarts == MOST_RESTARTS {
            return Ok(code(status));
        }
        let times = restarts + 1;
        eprintln!(
            "evac: agent_node has failed; it is started again ({times} of at most {MOST_RESTARTS} times)"
        );
        arguments.clone_from(&plan.agent_arguments);
        if plan.checkpoint.as_ref().is_some_and(|checkpoint| checkpoint.exists()) {
            arguments.extend(["--ros-args", "-p", "resume:=true", "--"].map(str::to_owned));
        }
    }
    Ok(ExitCode::FAILURE)
}

/// Keeps them alive; returns once one of them is given up.
async fn any_given_up(simulators: &mut [Simulator<'_>]) -> anyhow::Error {
    let mut watched: FuturesUnordered<_> = simulators.iter_mut().map(Simulator::watch).collect();
    match watched.next().await {
        Some(given_up) => given_up,
        // There is a robot.
        None => future::pending().await,
    }
}

/// The exit code of a program that ends as its agent did.
fn code(status: ExitStatus) -> ExitCode {
    let code = status.code().unwrap_or_else(|| 128 + status.signal().unwrap_or_default());
    ExitCode::from(u8::try_from(code).unwrap_or(u8::MAX))
}
