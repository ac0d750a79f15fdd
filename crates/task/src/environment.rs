//! The interface through which training and evaluation use an environment: a simulator (in process
//! or over DDS) or a robot.

use std::num::NonZeroU64;

use crate::{Action, Image};

/// An environment with one robot: it runs episodes and returns camera images and rewards.
///
/// Resets and steps are each split into two calls: `begin_*` sends the request and `finish_*` waits
/// for the result. Between the two calls, the learner updates its networks. The pending value
/// returned by `begin_*` is consumed by the matching `finish_*`, so a result cannot be collected
/// twice. Callers must finish a pending reset or step before they begin the next one.
///
/// # Examples
///
/// A corridor with the exit three steps ahead. Nothing runs in the background, so the pending step
/// is the action itself:
///
/// ```
/// use std::num::NonZeroU64;
///
/// use task::{Action, EXIT_REWARD, Environment, Image, STEP_REWARD, Step};
///
/// const EXIT: u8 = 3;
///
/// /// A corridor so narrow that every turn is blocked.
/// #[derive(Default)]
/// struct Corridor {
///     position: u8,
/// }
///
/// #[derive(Debug, thiserror::Error)]
/// #[error("the episode is over: reset the environment before the next step")]
/// struct EpisodeOver;
///
/// impl Corridor {
///     /// The image gets brighter as the robot approaches the exit.
///     fn image(&self) -> Image {
///         let bytes = vec![80 * self.position; Image::BYTES];
///         Image::try_from(bytes).expect("the buffer has the size of an image")
///     }
/// }
///
/// impl Environment for Corridor {
///     type Error = EpisodeOver;
///     type PendingReset = ();
///     type PendingStep = Action;
///
///     fn begin_reset(&mut self, _seed: NonZeroU64, _scenario: &str) -> Result<(), EpisodeOver> {
///         self.position = 0;
///         Ok(())
///     }
///
///     fn finish_reset(&mut self, _pending: ()) -> Result<Image, EpisodeOver> {
///         Ok(self.image())
///     }
///
///     fn begin_step(&mut self, action: Action) -> Result<Action, EpisodeOver> {
///         if self.position == EXIT { Err(EpisodeOver) } else { Ok(action) }
///     }
///
///     fn finish_step(&mut self, action: Action) -> Result<Step, EpisodeOver> {
///         let blocked = action.turn_degrees() != 0;
///         self.position += u8::from(!blocked);
///         let terminated = self.position == EXIT;
///         let reward = if terminated { EXIT_REWARD } else { STEP_REWARD };
///         Ok(Step { image: self.image(), reward, terminated, truncated: false, blocked })
///     }
/// }
///
/// let mut corridor = Corridor::default();
/// let mut image = corridor.reset(NonZeroU64::MIN, "empty")?;
/// assert_eq!(image.bytes()[0], 0);
///
/// let forward = Action::try_from(3).expect("3 is an action");
/// let mut steps = 0;
/// loop {
///     let step = corridor.step(forward)?;
///     (image, steps) = (step.image, steps + 1);
///     if step.terminated || step.truncated {
///         break;
///     }
/// }
/// assert_eq!((steps, image.bytes()[0]), (3, 240));
/// assert!(corridor.step(forward).is_err());
/// # Ok::<(), EpisodeOver>(())
/// ```
pub trait Environment {
    /// The error returned when a reset or a step fails.
    type Error: std::error::Error + Send + Sync + 'static;
    /// A reset that has begun but has not finished.
    type PendingReset;
    /// A step that has begun but has not finished.
    type PendingStep;

    /// Requests a new episode.
    ///
    /// `seed` determines all randomness in the episode. `scenario` is the name of a
    /// [`Scenario`](crate::Scenario) or of a scenario specific to this environment.
    ///
    /// # Errors
    ///
    /// Returns an error if the request cannot be sent or is rejected immediately.
    fn begin_reset(
        &mut self,
        seed: NonZeroU64,
        scenario: &str,
    ) -> Result<Self::PendingReset, Self::Error>;

    /// Waits for the new episode and returns its first image.
    ///
    /// # Errors
    ///
    /// Returns an error if the environment rejects the reset or does not respond.
    fn finish_reset(&mut self, pending: Self::PendingReset) -> Result<Image, Self::Error>;

    /// Requests one step.
    ///
    /// # Errors
    ///
    /// Returns an error if the request cannot be sent or is rejected immediately.
    fn begin_step(&mut self, action: Action) -> Result<Self::PendingStep, Self::Error>;

    /// Waits for the step to finish and returns its result.
    ///
    /// # Errors
    ///
    /// Returns an error if the environment rejects the step or does not respond.
    fn finish_step(&mut self, pending: Self::PendingStep) -> Result<Step, Self::Error>;

    /// Starts a new episode and returns its first image: [`begin_reset`](Self::begin_reset), then
    /// [`finish_reset`](Self::finish_reset).
    ///
    /// # Errors
    ///
    /// Returns an error if either call fails.
    fn reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<Image, Self::Error> {
        let pending = self.begin_reset(seed, scenario)?;
        self.finish_reset(pending)
    }

    /// Takes one step and returns its result: [`begin_step`](Self::begin_step), then
    /// [`finish_step`](Self::finish_step).
    ///
    /// # Errors
    ///
    /// Returns an error if either call fails.
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

/// The result of a step.
///
/// # Examples
///
/// ```
/// use task::{EXIT_REWARD, Image, Step};
///
/// let image = Image::try_from(vec![0u8; Image::BYTES])?;
/// let reward = EXIT_REWARD;
/// let step = Step { image, reward, terminated: true, truncated: false, blocked: false };
/// let is_over = step.terminated || step.truncated;
/// assert!(is_over);
/// # Ok::<(), task::image::InvalidImageSize>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The camera image after the step.
    pub image: Image,
    /// [`EXIT_REWARD`](crate::EXIT_REWARD) or [`STEP_REWARD`](crate::STEP_REWARD).
    pub reward: f32,
    /// Whether the robot reached the exit, which ends the episode.
    pub terminated: bool,
    /// Whether the episode ended at its step limit, before the robot reached the exit.
    pub truncated: bool,
    /// Whether a wall or an obstacle blocked the move; the pose is then unchanged.
    pub blocked: bool,
}
