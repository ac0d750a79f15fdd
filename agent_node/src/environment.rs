//! What training and evaluation ask of a room, whether it is simulated, over DDS or real.

use std::num::NonZeroU64;

use task::{Action, Image};
use thiserror::Error;

use crate::learning::dyna_q::Decision;

/// A room with a robot in it.
pub trait Environment {
    /// Asks for a new episode, everything random in which follows from the seed.
    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<(), EnvironmentError>;

    /// What the robot sees first in the episode that was asked for last.
    fn finish_reset(&mut self) -> Result<Image, EnvironmentError>;

    /// Begins an episode.
    fn reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<Image, EnvironmentError> {
        self.begin_reset(seed, scenario)?;
        self.finish_reset()
    }

    /// Begins to move the robot, and need not wait for the end of it: the learner has something to
    /// do meanwhile.
    ///
    /// The decision's values are for whoever watches; its action is what is done.
    fn begin_step(&mut self, decision: &Decision) -> Result<(), EnvironmentError>;

    /// What the step led to that was begun last.
    fn finish_step(&mut self) -> Result<Step, EnvironmentError>;

    /// Moves the robot.
    fn step(&mut self, decision: &Decision) -> Result<Step, EnvironmentError> {
        self.begin_step(decision)?;
        self.finish_step()
    }
}

impl<E: Environment> Environment for &mut E {
    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<(), EnvironmentError> {
        (**self).begin_reset(seed, scenario)
    }

    fn finish_reset(&mut self) -> Result<Image, EnvironmentError> {
        (**self).finish_reset()
    }

    fn begin_step(&mut self, decision: &Decision) -> Result<(), EnvironmentError> {
        (**self).begin_step(decision)
    }

    fn finish_step(&mut self) -> Result<Step, EnvironmentError> {
        (**self).finish_step()
    }
}

/// What a step led to.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What the robot sees now.
    pub image: Image,
    /// 0 at the exit, -0.1 otherwise.
    pub reward: f32,
    /// The exit is reached.
    pub terminated: bool,
    /// The episode was cut off.
    pub truncated: bool,
    /// The move met a wall or an obstacle, and was not made.
    pub blocked: bool,
}

/// Why the room does not answer.
#[derive(Debug, Error)]
pub enum EnvironmentError {
    /// The program ends.
    #[error("the node is shutting down")]
    Shutdown,
    /// Somebody else has begun another episode in the same room.
    #[error("somebody else has taken over the room: {0}")]
    TakenOver(String),
    /// The room refuses what it is asked.
    #[error("the simulator refuses: {0}")]
    Refused(String),
    /// The room cannot be reached.
    #[error(transparent)]
    Unreachable(#[from] ros_runtime::service::CallError),
    /// What came back is no image of the camera.
    #[error("the simulator sent {0}")]
    BadImage(String),
    /// Somebody wants the end of what was not begun.
    #[error("the end of a {0} that was not begun")]
    NotBegun(&'static str),
    /// The thread that speaks with the room is gone.
    #[error("the thread that speaks with the room has ended")]
    ThreadEnded,
    /// After a restart the room is not what it was.
    #[error(
        "the simulator does not repeat itself: step {step} of the episode with seed {seed} shows \
         another image than before; was it started with other parameters?"
    )]
    NotRepeatable {
        /// The step, 0 for the reset.
        step: u32,
        /// The episode's seed.
        seed: u64,
    },
}

/// An action decided before, for a room that is being brought back to where it was.
impl From<Action> for Decision {
    fn from(action: Action) -> Decision {
        Decision { action, values: None, explored: false }
    }
}
