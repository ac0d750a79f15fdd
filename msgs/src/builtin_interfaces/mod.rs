//! Messages of the ROS package `builtin_interfaces`.

mod time;

pub use time::Time;

/// The name of the ROS package.
const PACKAGE: &str = "builtin_interfaces";
