//! Nodes as child processes. Each exits when `evac` exits, even if `evac` is killed.

use std::{ffi::OsStr, path::Path, process::ExitStatus, time::Duration};

use crate::readiness::Readiness;
use anyhow::Context;
use rustix::process::{Pid, Signal, kill_process};
use tokio::{
    process::{Child, Command},
    time::timeout,
};

/// Time after SIGTERM at which a node that has not exited is killed. Saving a training run with a
/// full replay memory takes a second on a slow disk.
const STOP_TIMEOUT: Duration = Duration::from_secs(60);

/// A running node.
pub struct Node {
    child: Child,
}

impl Node {
    /// Starts the node `program` with the given arguments.
    ///
    /// Call this on a thread that lives as long as this process: a node receives SIGTERM when the
    /// thread that started it exits.
    ///
    /// # Errors
    ///
    /// Returns an error if the program cannot be started.
    pub fn start(
        program: &Path,
        arguments: &[impl AsRef<OsStr>],
        readiness: &Readiness,
    ) -> anyhow::Result<Node> {
        readiness.reset();
        let child = Command::new(program)
            .args(arguments)
            .arg("--parent")
            .arg(std::process::id().to_string())
            .env(Readiness::VARIABLE, readiness.socket())
            .envs(std::env::var_os("RAYON_NUM_THREADS").is_none().then_some((
                // candle's matrix products are too small for several threads.
                "RAYON_NUM_THREADS",
                "1",
            )))
            .stdin(std::process::Stdio::null())
            .spawn()
            .with_context(|| format!("cannot start {}", program.display()))?;
        Ok(Node { child })
    }

    /// Waits until the node exits.
    ///
    /// # Errors
    ///
    /// Returns an error if the operating system cannot report the exit status.
    pub async fn wait(&mut self) -> std::io::Result<ExitStatus> {
        self.child.wait().await
    }

    /// Sends SIGTERM to the node. Does nothing if the node has already exited.
    pub fn terminate(&self) {
        let pid = self.child.id().and_then(|id| Pid::from_raw(id.try_into().ok()?));
        if let Some(pid) = pid {
            let _ = kill_process(pid, Signal::TERM);
        }
    }

    /// Sends SIGTERM to the node and waits until it exits. Kills it after [`STOP_TIMEOUT`].
    ///
    /// # Errors
    ///
    /// Returns an error if the node cannot be killed, or if the operating system cannot report its
    /// exit status.
    pub async fn stop(&mut self) -> std::io::Result<ExitStatus> {
        self.terminate();
        match timeout(STOP_TIMEOUT, self.wait()).await {
            Ok(status) => status,
            Err(_) => {
                self.child.start_kill()?;
                self.wait().await
            }
        }
    }
}
