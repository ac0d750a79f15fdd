use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::{Quaternion, Vector3};
use crate::RosMessage;

/// `geometry_msgs/msg/Transform`: from one frame to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// The origin of the child in the parent, in metres.
    pub translation: Vector3,
    /// The axes of the child in the parent.
    pub rotation: Quaternion,
}

impl Message for Transform {}

impl RosMessage for Transform {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Transform";
}
