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
    channel::mpsc::{UnboundedReceiver, UnboundedSender, unbounded},
};
use ros_runtime::spin;
use task::Image;

use crate::{
    environment::{Environment, EnvironmentError, Step},
    learning::dyna_q::Decision,
};

/// How long the thread stays awake for the next order: longer than an update takes.
const WINDOW: Duration = Duration::from_micros(500);

/// A room that another thread speaks with.
pub struct Background {
    wanted: UnboundedSender<Wanted>,
    done: UnboundedReceiver<Done>,
}

enum Wanted {
    Reset(NonZeroU64, String),
    Step(Decision),
}

enum Done {
    Reset(Result<Image, EnvironmentError>),
    Step(Result<Step, EnvironmentError>),
}

impl Background {
    /// Starts a thread that does what is wanted of a room, until this value is dropped.
    pub fn start<'scope>(
        scope: &'scope Scope<'scope, '_>,
        mut room: impl Environment + Send + 'scope,
    ) -> std::io::Result<Background> {
        let (wanted, mut orders) = unbounded();
        let (results, done) = unbounded();
        Builder::new().name("room".into()).spawn_scoped(scope, move || {
            while let Some(order) = spin::block_on(WINDOW, orders.next()) {
                let result = match order {
                    Wanted::Reset(seed, scenario) => Done::Reset(room.reset(seed, &scenario)),
                    Wanted::Step(decision) => Done::Step(room.step(&decision)),
                };
                if results.unbounded_send(result).is_err() {
                    break;
                }
            }
        })?;
        Ok(Background { wanted, done })
    }

    fn order(&mut self, order: Wanted) -> Result<(), EnvironmentError> {
        self.wanted.unbounded_send(order).map_err(|_| EnvironmentError::ThreadEnded)
    }

    fn result(&mut self) -> Result<Done, EnvironmentError> {
        spin::block_on(WINDOW, self.done.next()).ok_or(EnvironmentError::ThreadEnded)
    }
}

impl Environment for Background {
    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<(), EnvironmentError> {
        self.order(Wanted::Reset(seed, scenario.to_owned()))
    }

    fn finish_reset(&mut self) -> Result<Image, EnvironmentError> {
        match self.result()? {
            Done::Reset(result) => result,
            Done::Step(_) => Err(EnvironmentError::NotBegun("reset")),
        }
    }

    fn begin_step(&mut self, decision: &Decision) -> Result<(), EnvironmentError> {
        self.order(Wanted::Step(decision.clone()))
    }

    fn finish_step(&mut self) -> Result<Step, EnvironmentError> {
        match self.result()? {
            Done::Step(result) => result,
            Done::Reset(_) => Err(EnvironmentError::NotBegun("step")),
        }
    }
}
