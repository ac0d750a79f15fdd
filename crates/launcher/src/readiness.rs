//! Readiness of nodes, reported by the protocol of systemd services (sd_notify(3)).

use std::{
    ffi::OsStr,
    io,
    path::{Path, PathBuf},
};

use tempfile::TempDir;
use tokio::{net::UnixDatagram, sync::watch};

/// The socket on which nodes report that they are ready.
pub struct Readiness {
    path: PathBuf,
    /// The number of nodes that are ready.
    ready: watch::Receiver<usize>,
    _directory: TempDir,
}

impl Readiness {
    /// The variable that tells a node the path of the socket.
    pub const VARIABLE: &str = "NOTIFY_SOCKET";

    /// Opens the socket. Messages are read at once, because a node would block on a full socket.
    pub fn listen() -> io::Result<Readiness> {
        let directory = tempfile::tempdir()?;
        let path = directory.path().join("ready");
        let socket = UnixDatagram::bind(&path)?;
        let (sender, ready) = watch::channel(0);
        tokio::spawn(async move {
            let mut message = [0; 256];
            while let Ok(length) = socket.recv(&mut message).await {
                let mut lines = message[..length].split(|byte| *byte == b'\n');
                if lines.any(|line| line == b"READY=1") {
                    sender.send_modify(|count| *count += 1);
                }
            }
        });
        Ok(Readiness { path, ready, _directory: directory })
    }

    /// The value of [`Readiness::VARIABLE`].
    pub fn socket(&self) -> &OsStr {
        Path::as_os_str(&self.path)
    }

    /// Waits until this number of nodes is ready.
    pub async fn of(&self, nodes: usize) {
        // The sender lives as long as the runtime.
        let _ = self.ready.clone().wait_for(|count| *count >= nodes).await;
    }
}
