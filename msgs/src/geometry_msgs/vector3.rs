use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `geometry_msgs/msg/Vector3`: a direction with a length; what it measures depends on where it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Forward, or about this axis.
    pub x: f64,
    /// To the left, or about this axis.
    pub y: f64,
    /// Upwards, or about this axis.
    pub z: f64,
}

impl Message for Vector3 {}

impl RosMessage for Vector3 {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Vector3";
}
