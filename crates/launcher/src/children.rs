//! The nodes as processes. Each is told to end with this one, so that none is left behind however it ends.

use std::{ffi::OsStr, path::Path, process::ExitStatus, time::Duration};

use crate::readiness::Readiness;
use anyhow::Context;
use rustix::process::{Pid, Signal, kill_process};
use tokio::{
    process::{Child, Command},
    time::timeout,
};

/// How long a node may take to end after it was told to, by the monotonic clock: to save a training with a
/// full memory takes a second on a slow disk.
const PATIENCE: Duration = Duration::from_secs(60);

/// A node that runs.
pub struct Node {
    child: Child,
}

impl Node {
    /// Starts a node with its own and its ROS arguments.
    ///
    /// It must be called on the thread that lives as long as this process: a child is sent its signal
    /// when the thread that has started it ends.
    pub fn start(
        program: &Path,
        arguments: &[impl AsRef<OsStr>],
        readiness: &Readiness,
    ) -> anyhow::Result<Node> {
        let child = Command::new(program)
            .args(arguments)
            .arg("--parent")
            .arg(std::process::id().to_string())
            .env(Readiness::VARIABLE, readiness.socket())
            .stdin(std::process::Stdio::null())
            .spawn()
            .with_context(|| program.display().to_string())?;
        Ok(Node { child })
    }

    /// Waits until it has ended.
    pub async fn wait(&mut self) -> std::io::Result<ExitStatus> {
        self.child.wait().await
    }

    /// Asks it to end; what has ended already does not hear it.
    pub fn terminate(&self) {
        let pid = self.child.id().and_then(|id| Pid::from_raw(id.try_into().ok()?));
        if let Some(pid) = pid {
            let _ = kill_process(pid, Signal::TERM);
        }
    }

    /// Has it end, and waits for that; one that does not is killed.
    pub async fn end(&mut self) -> std::io::Result<ExitStatus> {
        self.terminate();
        match timeout(PATIENCE, self.wait()).await {
            Ok(status) => status,
            Err(_) => {
                self.child.start_kill()?;
                self.wait().await
            }
        }
    }
}
