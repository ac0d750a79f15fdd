use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{
    Header, RosMessage,
    geometry_msgs::{PoseWithCovariance, TwistWithCovariance},
};

/// `nav_msgs/msg/Odometry`: where a robot is and how it moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// When, and the frame of the pose.
    pub header: Header,
    /// The frame of the robot, which is also that of the twist.
    pub child_frame_id: String,
    /// Where the robot is in the frame of the header.
    pub pose: PoseWithCovariance,
    /// How it moves in its own frame.
    pub twist: TwistWithCovariance,
}

impl Message for Odometry {}

impl RosMessage for Odometry {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Odometry";
}
