use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::Twist;
use crate::RosMessage;

/// `geometry_msgs/msg/TwistWithCovariance`: a twist, and how sure of it one is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    /// The twist.
    pub twist: Twist,
    /// The covariance of the velocities along x, y and z and about them, row by row; all zero if the
    /// twist is exact. `float64[36]` in ROS, which is the same on the wire.
    pub covariance: [[f64; 6]; 6],
}

impl Message for TwistWithCovariance {}

impl RosMessage for TwistWithCovariance {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "TwistWithCovariance";
}
