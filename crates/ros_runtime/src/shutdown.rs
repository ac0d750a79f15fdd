//! Shutdown of a node, requested by SIGINT, SIGTERM, SIGHUP or the program itself.

use std::{future::Future, sync::Arc};

use log::info;
use tokio::{
    runtime::Handle,
    signal::unix::{SignalKind, signal},
    sync::watch,
};

/// A request to shut down the node. Clones share the request.
///
/// [`Node::shutdown`](crate::Node::shutdown) returns the request that signals trigger.
///
/// # Examples
///
/// ```
/// use std::future::{pending, ready};
///
/// use ros_runtime::{
///     Shutdown,
///     spin::{WINDOW, block_on},
/// };
///
/// let shutdown = Shutdown::default();
/// assert_eq!(block_on(WINDOW, shutdown.unless_requested(ready(1))), Some(1));
/// shutdown.request();
/// assert_eq!(block_on(WINDOW, shutdown.unless_requested(pending::<i32>())), None);
/// ```
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
    /// Requests the shutdown.
    pub fn request(&self) {
        self.is_requested.send_replace(true);
    }

    /// Waits until the shutdown is requested. This method is cancel-safe.
    pub async fn requested(&self) {
        // Waiting fails only if the sender has been dropped, but `self` owns it.
        let _ = self.is_requested.subscribe().wait_for(|is_requested| *is_requested).await;
    }

    /// Returns the result of a future, or `None` if the shutdown is requested first. If the future
    /// is ready immediately, its result takes precedence.
    pub async fn unless_requested<T>(&self, work: impl Future<Output = T>) -> Option<T> {
        tokio::select! {
            biased;
            result = work => Some(result),
            _ = self.requested() => None,
        }
    }

    /// Makes SIGINT, SIGTERM and SIGHUP request the shutdown while the runtime exists.
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
                    // The terminal and a supervisor may both send a signal; only the first is
                    // logged.
                    if !shutdown.is_requested.send_replace(true) {
                        info!("{name}: shutting down");
                    }
                }
            });
        }
        Ok(())
    }
}
