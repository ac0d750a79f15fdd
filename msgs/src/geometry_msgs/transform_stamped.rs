use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::Transform;
use crate::{Header, RosMessage};

/// `geometry_msgs/msg/TransformStamped`: where one frame of tf is in another.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// When, and the parent.
    pub header: Header,
    /// The child.
    pub child_frame_id: String,
    /// Where the child is in the parent.
    pub transform: Transform,
}

impl Message for TransformStamped {}

impl RosMessage for TransformStamped {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "TransformStamped";
}
