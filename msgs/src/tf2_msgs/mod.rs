//! Messages of the ROS package `tf2_msgs`.

mod tf_message;

pub use tf_message::TFMessage;

/// The name of the ROS package.
const PACKAGE: &str = "tf2_msgs";
