//! Messages of the ROS package `nav_msgs`.

mod odometry;
mod path;

pub use odometry::Odometry;
pub use path::Path;

/// The name of the ROS package.
const PACKAGE: &str = "nav_msgs";
