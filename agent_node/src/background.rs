//! A room on a thread of its own.
//!
//! To ask a room over DDS takes system calls and wakes other threads: tens of microseconds in which
//! the learner could learn. On another thread they cost it nothing but the word that they are wanted.

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

/// How long a thread stays awake for the next order, or for what came of one: longer than an update
/// takes.
const WINDOW: Duration = Duration::from_micros(500);

/// A room that another thread speaks with.
pub struct Background<E> {
    orders: UnboundedSender<Order<E>>,
}

/// What is wanted of a room, and where its result goes.
enum Order<E> {
    Reset(NonZeroU64, String, oneshot::Sender<Result<Image, E>>),
    Step(Action, oneshot::Sender<Result<Step, E>>),
}

/// What will come of an order.
pub struct Pending<T, E>(oneshot::Receiver<Result<T, E>>);

/// The thread that speaks with the room is gone.
#[derive(Debug, Error, PartialEq)]
#[error("the thread that speaks with the room has ended")]
pub struct ThreadEnded;

impl<E: From<ThreadEnded> + Send> Background<E> {
    /// Starts a thread that does what is wanted of a room, until this value is dropped.
    ///
    /// # Errors
    ///
    /// The operating system has no thread to give.
    pub fn start<'scope>(
        scope: &'scope Scope<'scope, '_>,
        mut room: impl Environment<Error = E> + Send + 'scope,
    ) -> std::io::Result<Background<E>>
    where
        E: 'scope,
    {
        let (orders, mut wanted) = unbounded();
        Builder::new().name("room".into()).spawn_scoped(scope, move || {
            while let Some(order) = spin::block_on(WINDOW, wanted.next()) {
                // A result that is not wanted any more is lost with its receiver.
                match order {
                    Order::Reset(seed, scenario, done) => {
                        drop(done.send(room.reset(seed, &scenario)))
                    }
                    Order::Step(action, done) => drop(done.send(room.step(action))),
                }
            }
        })?;
        Ok(Background { orders })
    }

    fn order<T>(
        &self,
        order: impl FnOnce(oneshot::Sender<Result<T, E>>) -> Order<E>,
    ) -> Result<Pending<T, E>, E> {
        let (done, pending) = oneshot::channel();
        self.orders.unbounded_send(order(done)).map_err(|_| ThreadEnded)?;
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
        self.order(|done| Order::Reset(seed, scenario.to_owned(), done))
    }

    fn finish_reset(&mut self, pending: Pending<Image, E>) -> Result<Image, E> {
        pending.wait()
    }

    fn begin_step(&mut self, action: Action) -> Result<Pending<Step, E>, E> {
        self.order(|done| Order::Step(action, done))
    }

    fn finish_step(&mut self, pending: Pending<Step, E>) -> Result<Step, E> {
        pending.wait()
    }
}
