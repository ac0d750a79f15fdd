//! Readiness of nodes, reported with the protocol of systemd services (sd_notify(3)).

use std::{
    ffi::OsStr,
    future, io,
    path::{Path, PathBuf},
};

use tempfile::TempDir;
use tokio::{net::UnixDatagram, sync::watch};

/// The socket on which one node reports that it is ready.
pub struct Readiness {
    path: PathBuf,
    /// Whether the node has reported readiness since its last start.
    ready: watch::Sender<bool>,
    /// Deletes the socket when dropped.
    _directory: TempDir,
}

impl Readiness {
    /// The environment variable that holds the path of the socket.
    pub const VARIABLE: &str = "NOTIFY_SOCKET";

    /// Opens the socket and reads from it in a background task, because a node would block on a
    /// full socket. Must be called within a tokio runtime.
    ///
    /// # Errors
    ///
    /// Returns an error if the socket cannot be created.
    pub fn listen() -> io::Result<Readiness> {
        let directory = tempfile::tempdir()?;
        let path = directory.path().join("ready");
        let socket = UnixDatagram::bind(&path)?;
        let ready = watch::Sender::new(false);
        let sender = ready.clone();
        tokio::spawn(async move {
            let mut message = [0; 256];
            while let Ok(length) = socket.recv(&mut message).await {
                let mut lines = message[..length].split(|byte| *byte == b'\n');
                if lines.any(|line| line == b"READY=1") {
                    sender.send_replace(true);
                }
            }
        });
        Ok(Readiness { path, ready, _directory: directory })
    }

    /// Returns the path of the socket, the value for [`Readiness::VARIABLE`].
    pub fn socket(&self) -> &OsStr {
        Path::as_os_str(&self.path)
    }

    /// Marks the node as not ready. Call this whenever the node is started.
    pub fn reset(&self) {
        self.ready.send_replace(false);
    }

    /// Returns a receiver that tells whether the node is ready.
    pub fn watch(&self) -> watch::Receiver<bool> {
        self.ready.subscribe()
    }
}

/// Waits until all nodes are ready at the same time.
pub async fn all_ready(mut nodes: Vec<watch::Receiver<bool>>) {
    while !nodes.iter().all(|node| *node.borrow()) {
        for node in &mut nodes {
            if node.wait_for(|is_ready| *is_ready).await.is_err() {
                // The supervisor has given up on the node and reports why.
                future::pending::<()>().await;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn report(readiness: &Readiness) {
        let socket = UnixDatagram::unbound().unwrap();
        socket.send_to(b"READY=1\n", &readiness.path).await.unwrap();
        readiness.watch().wait_for(|is_ready| *is_ready).await.unwrap();
    }

    #[tokio::test]
    async fn a_node_that_restarts_counts_once() {
        let nodes = [Readiness::listen().unwrap(), Readiness::listen().unwrap()];
        let mut all = Box::pin(all_ready(nodes.iter().map(Readiness::watch).collect()));
        report(&nodes[0]).await;
        nodes[0].reset();
        report(&nodes[0]).await;
        assert!(futures::poll!(&mut all).is_pending(), "only one node is ready");
        nodes[0].reset();
        report(&nodes[1]).await;
        assert!(futures::poll!(&mut all).is_pending(), "only the other node is ready");
        report(&nodes[0]).await;
        all.await;
    }
}
