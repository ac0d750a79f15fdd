use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `visualization_msgs/msg/UVCoordinate`: a place in a texture, each part 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UVCoordinate {
    /// Across: 1 is the texture's width.
    pub u: f32,
    /// Along its height, which is 1.
    pub v: f32,
}

impl Message for UVCoordinate {}

impl RosMessage for UVCoordinate {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "UVCoordinate";
}
