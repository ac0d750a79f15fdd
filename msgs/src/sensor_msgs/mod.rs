//! Messages of the ROS package `sensor_msgs`.

mod image;

pub use image::Image;

/// The name of the ROS package.
const PACKAGE: &str = "sensor_msgs";
