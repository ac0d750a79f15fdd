use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{RosMessage, geometry_msgs::TransformStamped};

/// `tf2_msgs/msg/TFMessage`: where frames are in others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TFMessage {
    /// One for each child.
    pub transforms: Vec<TransformStamped>,
}

impl Message for TFMessage {}

impl RosMessage for TFMessage {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "TFMessage";
}
