//! Camera images and camera info.

use ros_interfaces::{
    builtin_interfaces::Time,
    sensor_msgs::Image,
    sensor_msgs::{CameraInfo, RegionOfInterest},
};

use super::{OPTICAL, header};
use crate::{
    Simulation,
    camera::{
        CHANNELS, Frame, HEIGHT, WIDTH,
        equidistant::{DISTORTION, FOCAL_LENGTH, PRINCIPAL_POINT},
    },
};

/// Returns image number `frame` since the latest step as a sensor_msgs/Image message: 20 x 7, `rgb8`,
/// 60 bytes per row.
pub(crate) fn image(simulation: &Simulation, frame: u32, stamp: Time) -> Image {
    let mut data = vec![0; Frame::LENGTH];
    if let Ok(bytes) = data.as_mut_slice().try_into() {
        simulation.frame_to(frame, bytes);
    }
    Image {
        header: header(OPTICAL, stamp),
        height: HEIGHT as u32,
        width: WIDTH as u32,
        encoding: "rgb8".to_owned(),
        is_bigendian: 0,
        step: (WIDTH * CHANNELS) as u32,
        data,
    }
}

/// Returns the intrinsics of the camera, which are the same for every image.
///
/// The projection matrix `p` has the same focal length and principal point as `k`.
pub(crate) fn camera_info(stamp: Time) -> CameraInfo {
    const F: f64 = FOCAL_LENGTH;
    let [x, y] = PRINCIPAL_POINT;
    CameraInfo {
        header: header(OPTICAL, stamp),
        height: HEIGHT as u32,
        width: WIDTH as u32,
        distortion_model: "equidistant".to_owned(),
        d: DISTORTION.to_vec(),
        k: [F, 0.0, x, 0.0, F, y, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [F, 0.0, x, 0.0, 0.0, F, y, 0.0, 0.0, 0.0, 1.0, 0.0],
        // No binning and no region of interest.
        binning_x: 0,
        binning_y: 0,
        roi: RegionOfInterest::default(),
    }
}
