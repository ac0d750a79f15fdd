use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Header, RosMessage};

/// `sensor_msgs/msg/CompressedImage`: an image as a file has it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// When the image was taken, and the optical frame of the camera.
    pub header: Header,
    /// The file's format, such as `png`.
    pub format: String,
    /// The file.
    pub data: Vec<u8>,
}

impl Message for CompressedImage {}

impl RosMessage for CompressedImage {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "CompressedImage";
}
