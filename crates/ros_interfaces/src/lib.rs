//! Standard ROS messages and services as Rust types.
//!
//! The build script generates these types with [`rosidl`] from the definitions in `interfaces`:
//!
//! - The message `sensor_msgs/msg/Image` becomes [`sensor_msgs::Image`].
//! - The service `rcl_interfaces/srv/GetParameters` becomes the marker type
//!   [`rcl_interfaces::GetParameters`] with [`rcl_interfaces::get_parameters::Request`] and
//!   `Response`.
//!
//! The fields are described in the ROS documentation of each package:
//! <https://docs.ros.org/en/jazzy/p/>.
//!
//! Generated messages implement [`RosMessage`], and generated services implement [`RosService`].
//! The types of other packages can be generated in the same way; see [`rosidl::generate`].
//!
//! # Examples
//!
//! ```
//! use ros_interfaces::{RosMessage, geometry_msgs::Quaternion, sensor_msgs::Image};
//!
//! assert_eq!(Image::full_name(), "sensor_msgs/msg/Image");
//! assert_eq!(Quaternion::default().w, 1.0); // the default in Quaternion.msg
//! ```

#![allow(missing_docs, reason = "the definitions have no comments; ROS documents the fields")]

mod interface;
mod interfaces;

pub use interface::{RosMessage, RosService};
pub use interfaces::Interfaces;
pub use ros2_client::Message;

include!(concat!(env!("OUT_DIR"), "/interfaces.rs"));
