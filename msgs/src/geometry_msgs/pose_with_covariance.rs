use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::Pose;
use crate::RosMessage;

/// `geometry_msgs/msg/PoseWithCovariance`: a pose, and how sure of it one is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// The covariance of x, y, z and the rotations about x, y and z, row by row; all zero if the pose
    /// is exact. `float64[36]` in ROS, which is the same on the wire.
    pub covariance: [[f64; 6]; 6],
}

impl Message for PoseWithCovariance {}

impl RosMessage for PoseWithCovariance {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "PoseWithCovariance";
}
