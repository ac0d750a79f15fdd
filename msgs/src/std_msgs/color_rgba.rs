use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `std_msgs/msg/ColorRGBA`: a colour, each part 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ColorRGBA {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Opacity: 0 cannot be seen.
    pub a: f32,
}

impl Message for ColorRGBA {}

impl RosMessage for ColorRGBA {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "ColorRGBA";
}
