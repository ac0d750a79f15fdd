use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::Pose;
use crate::{Header, RosMessage};

/// `geometry_msgs/msg/PoseStamped`: a pose with its time and frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// When, and in which frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

impl Message for PoseStamped {}

impl RosMessage for PoseStamped {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "PoseStamped";
}
