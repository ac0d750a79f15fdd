//! The standard ROS messages and services that a node needs, as Rust types.
//!
//! They are written at build time, by the crate [`rosidl`], from the definitions in `interfaces`: a
//! message `sensor_msgs/msg/Image` is [`sensor_msgs::Image`], a service
//! `rcl_interfaces/srv/GetParameters` the marker [`rcl_interfaces::GetParameters`] with
//! [`rcl_interfaces::get_parameters::Request`] and `Response`. What fields mean is documented at
//! <https://docs.ros.org/en/jazzy/p/>, by package.
//!
//! Other packages are written in the same way: [`RosMessage`] and [`RosService`] are what a generated
//! type implements.
//!
//! ```
//! use ros_interfaces::{RosMessage, geometry_msgs::Quaternion, sensor_msgs::Image};
//!
//! assert_eq!(Image::full_name(), "sensor_msgs/msg/Image");
//! assert_eq!(Quaternion::default().w, 1.0); // as its definition says
//! ```

#![allow(missing_docs, reason = "ROS documents the fields; the definitions here have no comments")]

mod interface;
mod interfaces;

pub use interface::{RosMessage, RosService};
pub use interfaces::Interfaces;
pub use ros2_client::Message;

include!(concat!(env!("OUT_DIR"), "/interfaces.rs"));
