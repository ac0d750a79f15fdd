//! The end of a node, requested by SIGINT, SIGTERM, SIGHUP or the program itself.

use std::{future::Future, sync::Arc};

use log::info;
use tokio::{
    runtime::Handle,
    signal::unix::{SignalKind, signal},
    sync::watch,
};

/// Whether the node shall end; a cheap handle that can be shared.
#[derive(Clone, Debug)]
pub struct Shutdown {
    is_requested: Arc<watch::Sender<bool>>,
}

impl Default for Shutdown {
    fn default() -> Shutdown {
        Shutdown { is_requested: Arc::new(watch::Sender::new(false)) }
    }
}

impl Shutdown {
    /// Asks the node to end.
    pub fn request(&self) {
        self.is_requested.send_replace(true);
    }

    /// Waits until the node shall end.
    pub async fn requested(&self) {
        // The sender lives in self, so that waiting cannot fail.
        let _ = self.is_requested.subscribe().wait_for(|is_requested| *is_requested).await;
    }

    /// The result of a future, or `None` if the node ends first.
    pub async fn unless_requested<T>(&self, work: impl Future<Output = T>) -> Option<T> {
        tokio::select! {
            biased;
            result = work => Some(result),
            _ = self.requested() => None,
        }
    }

    /// Turns SIGINT, SIGTERM and SIGHUP into a request, for as long as the runtime lives.
    pub(crate) fn listen_to_signals(&self, runtime: &Handle) -> std::io::Result<()> {
        let _context = runtime.enter();
        for (kind, name) in [
            (SignalKind::interrupt(), "SIGINT"),
            (SignalKind::terminate(), "SIGTERM"),
            (SignalKind::hangup(), "SIGHUP"),
        ] {
            let (mut signals, shutdown) = (signal(kind)?, self.clone());
            runtime.spawn(async move {
                while signals.recv().await.is_some() {
                    // A terminal and a supervisor may both say so.
                    if !shutdown.is_requested.send_replace(true) {
                        info!("{name}: shutting down");
                    }
                }
            });
        }
        Ok(())
    }
}
