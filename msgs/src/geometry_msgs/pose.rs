use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::{Point, Quaternion};
use crate::RosMessage;

/// `geometry_msgs/msg/Pose`: where something is, and which way it faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Where.
    pub position: Point,
    /// Which way.
    pub orientation: Quaternion,
}

impl Message for Pose {}

impl RosMessage for Pose {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Pose";
}
