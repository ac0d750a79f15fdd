use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Header, RosMessage, geometry_msgs::PoseStamped};

/// `nav_msgs/msg/Path`: poses, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// When, and the frame of the path.
    pub header: Header,
    /// The poses.
    pub poses: Vec<PoseStamped>,
}

impl Message for Path {}

impl RosMessage for Path {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Path";
}
