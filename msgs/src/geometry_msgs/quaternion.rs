use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `geometry_msgs/msg/Quaternion`: a rotation, as a quaternion of length 1.
///
/// As in ROS, the default is no rotation, not four zeros.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// The first imaginary part.
    pub x: f64,
    /// The second imaginary part.
    pub y: f64,
    /// The third imaginary part.
    pub z: f64,
    /// The real part.
    pub w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

impl Message for Quaternion {}

impl RosMessage for Quaternion {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Quaternion";
}
