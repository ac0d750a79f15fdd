//! What training and evaluation ask of a room, whether it is simulated, over DDS or real.

use std::num::NonZeroU64;

use crate::{Action, Image};

/// A room with a robot in it.
///
/// A reset and a step are two calls each: the first asks, and the second waits for what comes of it,
/// so that the learner can update its networks meanwhile. What is under way is a value of its own,
/// which is finished once.
pub trait Environment {
    /// Why the room does not answer.
    type Error: std::error::Error + Send + Sync + 'static;
    /// A reset under way.
    type PendingReset;
    /// A step under way.
    type PendingStep;

    /// Asks for a new episode, everything random in which follows from the seed.
    ///
    /// # Errors
    ///
    /// The room cannot be asked.
    fn begin_reset(
        &mut self,
        seed: NonZeroU64,
        scenario: &str,
    ) -> Result<Self::PendingReset, Self::Error>;

    /// What the robot sees first in the episode.
    ///
    /// # Errors
    ///
    /// The room refuses, or does not answer.
    fn finish_reset(&mut self, pending: Self::PendingReset) -> Result<Image, Self::Error>;

    /// Asks the robot to move.
    ///
    /// # Errors
    ///
    /// The room cannot be asked.
    fn begin_step(&mut self, action: Action) -> Result<Self::PendingStep, Self::Error>;

    /// What the step led to.
    ///
    /// # Errors
    ///
    /// The room refuses, or does not answer.
    fn finish_step(&mut self, pending: Self::PendingStep) -> Result<Step, Self::Error>;

    /// Begins an episode and waits for its first image.
    ///
    /// # Errors
    ///
    /// As both halves.
    fn reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<Image, Self::Error> {
        let pending = self.begin_reset(seed, scenario)?;
        self.finish_reset(pending)
    }

    /// Moves the robot and waits for what comes of it.
    ///
    /// # Errors
    ///
    /// As both halves.
    fn step(&mut self, action: Action) -> Result<Step, Self::Error> {
        let pending = self.begin_step(action)?;
        self.finish_step(pending)
    }
}

impl<E: Environment> Environment for &mut E {
    type Error = E::Error;
    type PendingReset = E::PendingReset;
    type PendingStep = E::PendingStep;

    fn begin_reset(
        &mut self,
        seed: NonZeroU64,
        scenario: &str,
    ) -> Result<E::PendingReset, E::Error> {
        (**self).begin_reset(seed, scenario)
    }

    fn finish_reset(&mut self, pending: E::PendingReset) -> Result<Image, E::Error> {
        (**self).finish_reset(pending)
    }

    fn begin_step(&mut self, action: Action) -> Result<E::PendingStep, E::Error> {
        (**self).begin_step(action)
    }

    fn finish_step(&mut self, pending: E::PendingStep) -> Result<Step, E::Error> {
        (**self).finish_step(pending)
    }
}

/// What a step led to.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What the robot sees now.
    pub image: Image,
    /// [`EXIT_REWARD`](crate::EXIT_REWARD) or [`STEP_REWARD`](crate::STEP_REWARD).
    pub reward: f32,
    /// The exit is reached.
    pub terminated: bool,
    /// The episode was cut off.
    pub truncated: bool,
    /// The move met a wall or an obstacle, and was not made.
    pub blocked: bool,
}
