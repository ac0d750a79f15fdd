//! Messages of the ROS package `std_msgs`.

mod header;

pub use header::Header;

/// The name of the ROS package.
const PACKAGE: &str = "std_msgs";
