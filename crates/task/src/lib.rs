//! What both sides of the wire agree on, without ROS and without a learner.
//!
//! - [`action`]: the seven moves of the robot (equation 3 of the paper);
//! - [`scenario`]: the rooms that an episode can take place in;
//! - [`image`]: the camera image, 20 x 7 pixels;
//! - [`reward`]: what a step is worth;
//! - [`environment`]: what training and evaluation ask of a room;
//! - [`seeds`]: the seed and the scenario of each episode of a run;
//! - [`random`]: random numbers that are the same on every machine;
//! - [`measures`]: how good a policy is, and [`fewest_steps`], which it is measured by.
//!
//! ```
//! use task::{Action, Scenario};
//!
//! let left = Action::try_from(5)?;
//! assert_eq!(left.turn_degrees(), 90);
//! let scenario: Scenario = "three_moving".parse()?;
//! assert!(scenario.moving());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod action;
pub mod environment;
pub mod fewest_steps;
pub mod image;
pub mod measures;
pub mod random;
pub mod reward;
pub mod scenario;
pub mod seeds;

pub use action::Action;
pub use environment::{Environment, Step};
pub use fewest_steps::FewestSteps;
pub use image::Image;
pub use measures::{Evaluation, TestEpisode};
pub use random::Random;
pub use reward::{EXIT_REWARD, STEP_REWARD};
pub use scenario::Scenario;
