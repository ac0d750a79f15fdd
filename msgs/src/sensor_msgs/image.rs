use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Header, RosMessage};

/// `sensor_msgs/msg/Image`: an uncompressed image.
///
/// `Image::default()` is the empty image (0 x 0, no bytes) that a refused request is answered with.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Image {
    /// When the image was taken, and the optical frame of the camera (z forward, x right, y down).
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
    /// How a pixel is encoded, such as `rgb8`: three bytes, red, green and blue.
    pub encoding: String,
    /// Nonzero if numbers of more than one byte are big-endian; says nothing about `rgb8`.
    pub is_bigendian: u8,
    /// Bytes from the start of one row to the start of the next.
    pub step: u32,
    /// The rows from the top, each from the left: `step * height` bytes.
    pub data: Vec<u8>,
}

impl Message for Image {}

impl RosMessage for Image {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Image";
}
