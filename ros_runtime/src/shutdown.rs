//! The end of a node: asked for by SIGINT or SIGTERM, or because DDS is gone.

use std::{future::Future, sync::Arc};

use log::info;
use thiserror::Error;
use tokio::{
    runtime::Handle,
    signal::unix::{SignalKind, signal},
    sync::watch,
};

/// The signal that lets a stopped process go on; tokio has no name for it.
const SIGCONT: i32 = if cfg!(target_os = "macos") { 19 } else { 18 };

/// Whether the node shall end; a cheap handle that can be shared.
#[derive(Clone, Debug)]
pub struct Shutdown {
    state: Arc<watch::Sender<State>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Running,
    Requested,
    Continued,
}

/// The process was stopped (SIGSTOP, Ctrl-Z) and continued.
///
/// RustDDS 0.15 takes the wait that this interrupts for an error and ends its threads. A node that
/// hears nobody and is heard by nobody must not look alive.
#[derive(Debug, Error, PartialEq)]
#[error("the process was stopped and continued, which DDS does not survive: start the node again")]
pub struct Continued;

impl Default for Shutdown {
    fn default() -> Shutdown {
        Shutdown { state: Arc::new(watch::Sender::new(State::Running)) }
    }
}

impl Shutdown {
    /// Asks the node to end.
    pub fn request(&self) {
        self.state.send_replace(State::Requested);
    }

    /// Fails if the node ends for another reason than that somebody asked.
    pub fn check(&self) -> Result<(), Continued> {
        if *self.state.borrow() == State::Continued { Err(Continued) } else { Ok(()) }
    }

    /// Waits until the node shall end.
    pub async fn requested(&self) {
        // The sender lives in self, so that waiting cannot fail.
        let _ = self.state.subscribe().wait_for(|state| *state != State::Running).await;
    }

    /// The result of a future, or `None` if the node ends first.
    pub async fn unless_requested<T>(&self, work: impl Future<Output = T>) -> Option<T> {
        tokio::select! {
            biased;
            result = work => Some(result),
            _ = self.requested() => None,
        }
    }

    /// Turns SIGINT and SIGTERM into a request, for as long as the runtime lives.
    pub(crate) fn listen_to_signals(&self, runtime: &Handle) -> std::io::Result<()> {
        let _context = runtime.enter();
        for (kind, name) in
            [(SignalKind::interrupt(), "SIGINT"), (SignalKind::terminate(), "SIGTERM")]
        {
            let (mut signals, shutdown) = (signal(kind)?, self.clone());
            runtime.spawn(async move {
                while signals.recv().await.is_some() {
                    info!("{name}: shutting down");
                    shutdown.request();
                }
            });
        }
        let (mut continued, state) = (signal(SignalKind::from_raw(SIGCONT))?, self.state.clone());
        runtime.spawn(async move {
            if continued.recv().await.is_some() {
                // timeout(1) and systemd send it after SIGTERM, to a process that nobody stopped.
                state.send_if_modified(|state| {
                    let is_running = *state == State::Running;
                    if is_running {
                        *state = State::Continued;
                    }
                    is_running
                });
            }
        });
        Ok(())
    }
}
