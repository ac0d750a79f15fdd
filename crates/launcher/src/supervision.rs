//! Runs simulators and an agent, restarts those that fail, and stops the simulators when the agent
//! exits.

use std::{
    future,
    os::unix::process::ExitStatusExt,
    path::PathBuf,
    pin::pin,
    process::{ExitCode, ExitStatus},
    time::{Duration, Instant},
};

use futures::{StreamExt, stream::FuturesUnordered};
use tokio::{
    signal::unix::{Signal, SignalKind, signal},
    time::sleep,
};

use crate::{
    children::Node,
    readiness::{Readiness, all_ready},
};

/// Delay before a simulator is restarted.
const RESTART_DELAY: Duration = Duration::from_secs(1);
/// A simulator that has run for this long is considered stable, and its failure count is reset.
const STABLE_AFTER: Duration = Duration::from_secs(10);
/// Number of consecutive failures after which a simulator is no longer restarted.
const MAX_FAILURES: u32 = 10;
/// Maximum number of restarts of the agent.
const MAX_RESTARTS: u32 = 3;
/// Exit code of a Rust program that panics.
const PANIC_EXIT_CODE: i32 = 101;
/// Signal number of SIGABRT. A node aborts if it exceeds its memory limit or if a panic cannot
/// unwind.
const SIGABRT: i32 = 6;

/// The nodes to run.
pub struct Plan {
    /// Program of the simulator.
    pub simulator: PathBuf,
    /// Arguments of each simulator; empty if the agent drives a robot.
    pub simulators: Vec<Vec<String>>,
    /// Program of the agent.
    pub agent: PathBuf,
    /// Arguments of the agent.
    pub agent_arguments: Vec<String>,
    /// Checkpoint of a training run. A restarted agent resumes from it if the file exists.
    pub checkpoint: Option<PathBuf>,
}

/// The signals that stop all nodes: SIGINT, SIGTERM and SIGHUP.
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

    /// Waits for any of the signals.
    async fn any(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
            _ = self.hang_up.recv() => {}
        }
    }
}

/// A supervised simulator.
struct Simulator<'a> {
    plan: &'a Plan,
    readiness: Readiness,
    arguments: &'a [String],
    node: Node,
    started: Instant,
    /// Number of consecutive exits; a run of at least [`STABLE_AFTER`] resets it.
    failures: u32,
}

impl<'a> Simulator<'a> {
    fn start(plan: &'a Plan, arguments: &'a [String]) -> anyhow::Result<Simulator<'a>> {
        let readiness = Readiness::listen()?;
        let node = Node::start(&plan.simulator, arguments, &readiness)?;
        Ok(Simulator { plan, readiness, arguments, node, started: Instant::now(), failures: 0 })
    }

    /// Restarts the simulator whenever it exits. Returns the error that prevents a restart.
    async fn supervise(&mut self) -> anyhow::Error {
        loop {
            match self.restart_after_exit().await {
                Ok(()) => {}
                Err(error) => return error,
            }
        }
    }

    /// Waits until the simulator exits, and restarts it.
    async fn restart_after_exit(&mut self) -> anyhow::Result<()> {
        let status = self.node.wait().await?;
        if self.started.elapsed() >= STABLE_AFTER {
            self.failures = 0;
        }
        self.failures += 1;
        if self.failures == MAX_FAILURES {
            anyhow::bail!(
                "sim_node exited {MAX_FAILURES} times in a row, the last time with {status}"
            );
        }
        eprintln!("evac: sim_node exited with {status}; restarting it");
        sleep(RESTART_DELAY).await;
        self.node = Node::start(&self.plan.simulator, self.arguments, &self.readiness)?;
        self.started = Instant::now();
        Ok(())
    }
}

/// Like [`run`], on the current thread.
///
/// # Errors
///
/// Returns an error if a node cannot be started, or if a simulator fails repeatedly.
pub fn supervise(plan: &Plan) -> anyhow::Result<ExitCode> {
    // Single-threaded, because a node receives SIGTERM when the thread that started it exits.
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(run(plan))
}

/// Runs the nodes until the agent exits or a signal arrives, and returns the agent's exit code.
///
/// # Errors
///
/// Returns an error if a node cannot be started, or if a simulator fails repeatedly.
async fn run(plan: &Plan) -> anyhow::Result<ExitCode> {
    let mut simulators = Vec::new();
    for arguments in &plan.simulators {
        simulators.push(Simulator::start(plan, arguments)?);
    }
    let outcome = run_agent(plan, &mut simulators).await;
    for simulator in &simulators {
        simulator.node.terminate();
    }
    for simulator in &mut simulators {
        let _ = simulator.node.stop().await;
    }
    outcome
}

/// Starts the agent when all simulators are ready, and restarts it if it crashes.
async fn run_agent(plan: &Plan, simulators: &mut [Simulator<'_>]) -> anyhow::Result<ExitCode> {
    let mut signals = Signals::new()?;
    let readiness = Readiness::listen()?;
    let ready = all_ready(simulators.iter().map(|simulator| simulator.readiness.watch()).collect());
    // A single future for the whole run: a new one would lose a restart that is in progress.
    let mut supervision = pin!(supervise_all(simulators));
    tokio::select! {
        () = ready => {}
        error = &mut supervision => return Err(error),
        () = signals.any() => return Ok(ExitCode::SUCCESS),
    }
    let mut arguments = plan.agent_arguments.clone();
    for restarts in 0.. {
        let mut agent = Node::start(&plan.agent, &arguments, &readiness)?;
        let status = tokio::select! {
            status = agent.wait() => status?,
            error = &mut supervision => {
                let _ = agent.stop().await;
                return Err(error);
            }
            () = signals.any() => return Ok(exit_code(agent.stop().await?)),
        };
        // Any other exit is a success, or an error that would recur after a restart.
        let crashed = status.code() == Some(PANIC_EXIT_CODE) || status.signal() == Some(SIGABRT);
        if !crashed || restarts == MAX_RESTARTS {
            return Ok(exit_code(status));
        }
        eprintln!(
            "evac: agent_node crashed; restarting it ({} of at most {MAX_RESTARTS} restarts)",
            restarts + 1
        );
        arguments.clone_from(&plan.agent_arguments);
        if plan.checkpoint.as_ref().is_some_and(|checkpoint| checkpoint.exists()) {
            arguments.extend(["--ros-args", "-p", "resume:=true", "--"].map(str::to_owned));
        }
    }
    Ok(ExitCode::FAILURE)
}

/// Restarts the simulators whenever they exit. Returns the first error that prevents a restart;
/// without simulators, never returns.
async fn supervise_all(simulators: &mut [Simulator<'_>]) -> anyhow::Error {
    let mut supervised: FuturesUnordered<_> =
        simulators.iter_mut().map(Simulator::supervise).collect();
    match supervised.next().await {
        Some(error) => error,
        None => future::pending().await,
    }
}

/// Converts the exit status of the agent to the exit code of `evac`: 128 plus the signal number
/// if a signal ended the agent, as in a shell.
fn exit_code(status: ExitStatus) -> ExitCode {
    let code = status.code().unwrap_or_else(|| 128 + status.signal().unwrap_or_default());
    ExitCode::from(u8::try_from(code).unwrap_or(u8::MAX))
}
