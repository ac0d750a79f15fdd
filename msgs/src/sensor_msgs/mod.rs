//! Messages of the ROS package `sensor_msgs`.

mod camera_info;
mod compressed_image;
mod image;
mod region_of_interest;

pub use camera_info::CameraInfo;
pub use compressed_image::CompressedImage;
pub use image::Image;
pub use region_of_interest::RegionOfInterest;

/// The name of the ROS package.
const PACKAGE: &str = "sensor_msgs";
