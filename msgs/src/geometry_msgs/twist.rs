use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::Vector3;
use crate::RosMessage;

/// `geometry_msgs/msg/Twist`: how fast something moves and turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// In metres per second.
    pub linear: Vector3,
    /// In radians per second, about the three axes.
    pub angular: Vector3,
}

impl Message for Twist {}

impl RosMessage for Twist {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Twist";
}
