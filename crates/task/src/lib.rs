//! The task definition shared by the simulator and the agent, independent of ROS and the learner.
//!
//! - [`action`]: the robot's seven actions (equation 3 of the paper).
//! - [`scenario`]: the obstacles in the room.
//! - [`image`]: the camera image, 20 x 7 RGB pixels.
//! - [`reward`]: the reward for a step.
//! - [`environment`]: the interface to a simulator or a robot, used by training and evaluation.
//! - [`seeds`]: the seed and scenario of each episode in a run.
//! - [`random`]: random numbers that are identical on every machine.
//! - [`measures`]: the results of an evaluation.
//! - [`names`]: values that are selected by name.
//! - [`robustness`]: the results of an evaluation under perturbations.
//! - [`shortest_paths`]: the full-knowledge shortest paths, the baseline for evaluations.
//!
//! # Examples
//!
//! ```
//! use task::{Action, Scenario};
//!
//! let left = Action::try_from(5)?;
//! assert_eq!(left.turn_degrees(), 90);
//! let scenario: Scenario = "three_moving".parse()?;
//! assert!(scenario.has_moving_obstacles());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! See [`Environment`] for a complete implementation of an environment.

pub mod action;
pub mod environment;
pub mod image;
pub mod measures;
pub mod names;
pub mod random;
pub mod reward;
pub mod robustness;
pub mod scenario;
pub mod seeds;
pub mod shortest_paths;

pub use action::Action;
pub use environment::{Environment, Step};
pub use image::Image;
pub use measures::{Evaluation, EvaluationEpisode};
pub use random::Random;
pub use reward::{EXIT_REWARD, STEP_REWARD};
pub use robustness::RobustnessRow;
pub use scenario::Scenario;
pub use shortest_paths::ShortestPaths;
