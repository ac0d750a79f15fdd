use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `geometry_msgs/msg/Point`: a position, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Forward.
    pub x: f64,
    /// To the left.
    pub y: f64,
    /// Upwards.
    pub z: f64,
}

impl Message for Point {}

impl RosMessage for Point {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Point";
}
