//! What both sides of the wire agree on, without ROS and without a learner.
//!
//! - [`action`]: the seven moves of the robot (equation 3 of the paper);
//! - [`scenario`]: the rooms that an episode can take place in;
//! - [`image`]: the camera image, 20 x 7 pixels.
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
pub mod image;
pub mod scenario;

pub use action::Action;
pub use image::Image;
pub use scenario::Scenario;
