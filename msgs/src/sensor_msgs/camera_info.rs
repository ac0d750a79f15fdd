use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::RegionOfInterest;
use crate::{Header, RosMessage};

/// `sensor_msgs/msg/CameraInfo`: how the camera of an image projects the world.
///
/// Pixels are counted from 0 at the middle of the upper left one. The matrices are row by row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraInfo {
    /// The header of the image.
    pub header: Header,
    /// Rows of the image.
    pub height: u32,
    /// Columns of the image.
    pub width: u32,
    /// The model of the lens, such as `equidistant`.
    pub distortion_model: String,
    /// The coefficients of that model.
    pub d: Vec<f64>,
    /// The 3x3 matrix of the raw image: focal lengths and principal point, in pixels.
    pub k: [f64; 9],
    /// The 3x3 rotation to the rectified image.
    pub r: [f64; 9],
    /// The 3x4 projection into the rectified image.
    pub p: [f64; 12],
    /// Columns of the sensor for one of the image; 0 means 1.
    pub binning_x: u32,
    /// Rows of the sensor for one of the image; 0 means 1.
    pub binning_y: u32,
    /// The part of the sensor that the image shows.
    pub roi: RegionOfInterest,
}

impl Message for CameraInfo {}

impl RosMessage for CameraInfo {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "CameraInfo";
}
