//! Messages of the ROS package `builtin_interfaces`.

mod duration;
mod time;

pub use duration::Duration;
pub use time::Time;

/// The name of the ROS package.
const PACKAGE: &str = "builtin_interfaces";
