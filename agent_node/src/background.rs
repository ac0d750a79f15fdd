//! Runs an environment on its own thread.
//!
//! A request over DDS needs system calls and thread wake-ups. They take tens of microseconds, which
//! the learner could spend on network updates. With a separate thread, a request costs the learner
//! only one channel message.

use std::{
    num::NonZeroU64,
    thread::{Builder, Scope},
    time::Duration,
};

use futures::{
    StreamExt,
    channel::{
        mpsc::{UnboundedSender, unbounded},
        oneshot,
    },
};
use ros_runtime::spin;
use task::{Action, Environment, Image, Step};
use thiserror::Error;

/// How long a thread that waits for a request or a result stays awake before it sleeps. This is
/// longer than a network update, so the kernel does not have to wake either thread during training.
const WINDOW: Duration = Duration::from_micros(500);

/// An environment that runs on its own thread.
///
/// Implements [`Environment`]: `begin_*` sends a request to the thread and returns at once;
/// `finish_*` waits for the result.
pub struct Background<E> {
    requests: UnboundedSender<Request<E>>,
}

/// A request to the environment, with the channel for its result.
enum Request<E> {
    Reset(NonZeroU64, String, oneshot::Sender<Result<Image, E>>),
    Step(Action, oneshot::Sender<Result<Step, E>>),
}

/// The pending result of a reset or step.
pub struct Pending<T, E>(oneshot::Receiver<Result<T, E>>);

/// The error returned if the environment thread has ended.
#[derive(Debug, Error, PartialEq)]
#[error("the environment thread has ended")]
pub struct ThreadEnded;

impl<E: From<ThreadEnded> + Send> Background<E> {
    /// Starts a thread that executes requests on `environment` until the returned value is dropped.
    ///
    /// # Errors
    ///
    /// Returns an error if the operating system cannot create a thread.
    pub fn start<'scope>(
        scope: &'scope Scope<'scope, '_>,
        mut environment: impl Environment<Error = E> + Send + 'scope,
    ) -> std::io::Result<Background<E>>
    where
        E: 'scope,
    {
        let (requests, mut incoming) = unbounded();
        Builder::new().name("environment".into()).spawn_scoped(scope, move || {
            while let Some(request) = spin::block_on(WINDOW, incoming.next()) {
                // Sending fails only if the receiver was dropped and the result is no longer
                // needed.
                match request {
                    Request::Reset(seed, scenario, result) => {
                        drop(result.send(environment.reset(seed, &scenario)))
                    }
                    Request::Step(action, result) => drop(result.send(environment.step(action))),
                }
            }
        })?;
        Ok(Background { requests })
    }

    fn send<T>(
        &self,
        request: impl FnOnce(oneshot::Sender<Result<T, E>>) -> Request<E>,
    ) -> Result<Pending<T, E>, E> {
        let (result, pending) = oneshot::channel();
        self.requests.unbounded_send(request(result)).map_err(|_| ThreadEnded)?;
        Ok(Pending(pending))
    }
}

impl<T, E: From<ThreadEnded>> Pending<T, E> {
    fn wait(self) -> Result<T, E> {
        spin::block_on(WINDOW, self.0).map_err(|_| ThreadEnded)?
    }
}

impl<E> Environment for Background<E>
where
    E: std::error::Error + From<ThreadEnded> + Send + Sync + 'static,
{
    type Error = E;
    type PendingReset = Pending<Image, E>;
    type PendingStep = Pending<Step, E>;

    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<Pending<Image, E>, E> {
        self.send(|result| Request::Reset(seed, scenario.to_owned(), result))
    }

    fn finish_reset(&mut self, pending: Pending<Image, E>) -> Result<Image, E> {
        pending.wait()
    }

    fn begin_step(&mut self, action: Action) -> Result<Pending<Step, E>, E> {
        self.send(|result| Request::Step(action, result))
    }

    fn finish_step(&mut self, pending: Pending<Step, E>) -> Result<Step, E> {
        pending.wait()
    }
}
