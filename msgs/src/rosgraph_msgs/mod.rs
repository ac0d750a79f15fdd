//! Messages of the ROS package `rosgraph_msgs`.

mod clock;

pub use clock::Clock;

/// The name of the ROS package.
const PACKAGE: &str = "rosgraph_msgs";
