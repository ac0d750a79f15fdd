//! The reward for a step (section 2.3 of the paper).
//!
//! # Examples
//!
//! ```
//! use task::{EXIT_REWARD, STEP_REWARD};
//!
//! // The return of an episode in which the robot reaches the exit on the 11th step.
//! let episode_return = 10.0 * STEP_REWARD + EXIT_REWARD;
//! assert!((episode_return - -1.0).abs() < 1e-6);
//! ```

/// Reward for the step that reaches the exit.
pub const EXIT_REWARD: f32 = 0.0;

/// Reward for every other step, including blocked ones.
pub const STEP_REWARD: f32 = -0.1;
