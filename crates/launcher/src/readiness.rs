//! When a node is ready: it says so as services do to systemd (sd_notify(3)).

use std::{
    ffi::OsStr,
    io,
    path::{Path, PathBuf},
};

use tempfile::TempDir;
use tokio::{net::UnixDatagram, sync::watch};

/// Where nodes say that they are ready.
pub struct Readiness {
    path: PathBuf,
    /// How many have said so.
    ready: watch::Receiver<usize>,
    _directory: TempDir,
}

impl Readiness {
    /// The variable that tells a node the path of the socket.
    pub const VARIABLE: &str = "NOTIFY_SOCKET";

    /// Listens from now on; what is sent is read whether anybody waits for it or not, because a
    /// node would wait for a socket that is full.
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

    /// Waits until so many nodes have said that they are ready.
    pub async fn of(&self, nodes: usize) {
        // The sender lives as long as the runtime.
        let _ = self.ready.clone().wait_for(|count| *count >= nodes).await;
    }
}
