use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `sensor_msgs/msg/RegionOfInterest`: a part of an image; all zero is the whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RegionOfInterest {
    /// Columns to the left of it.
    pub x_offset: u32,
    /// Rows above it.
    pub y_offset: u32,
    /// Its rows.
    pub height: u32,
    /// Its columns.
    pub width: u32,
    /// Whether a rectified part is to be computed from the raw image.
    pub do_rectify: bool,
}

impl Message for RegionOfInterest {}

impl RosMessage for RegionOfInterest {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "RegionOfInterest";
}
