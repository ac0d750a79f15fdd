//! Messages of the ROS package `std_msgs`.

mod color_rgba;
mod header;

pub use color_rgba::ColorRGBA;
pub use header::Header;

/// The name of the ROS package.
const PACKAGE: &str = "std_msgs";
