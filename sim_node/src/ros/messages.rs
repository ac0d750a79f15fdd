//! The world's words as ROS messages.

use evac_msgs::{Header, Image, Time};

use crate::camera::{CHANNELS, Frame, HEIGHT, WIDTH};

/// REP-103: z forward, x right, y down.
const OPTICAL_FRAME: &str = "camera_optical_frame";

/// The time of the simulation as a stamp.
pub(super) fn stamp(nanoseconds: u64) -> Time {
    const SECOND: u64 = 1_000_000_000;
    // builtin_interfaces/Time ends after 68 years.
    let sec = i32::try_from(nanoseconds / SECOND).unwrap_or(i32::MAX);
    Time { sec, nanosec: (nanoseconds % SECOND) as u32 }
}

/// An image of the camera as sensor_msgs/Image: 20 x 7, rgb8, 60 bytes a row.
pub(super) fn image(frame: &Frame, stamp: Time) -> Image {
    Image {
        header: Header { stamp, frame_id: OPTICAL_FRAME.to_owned() },
        height: HEIGHT as u32,
        width: WIDTH as u32,
        encoding: "rgb8".to_owned(),
        is_bigendian: 0,
        step: (WIDTH * CHANNELS) as u32,
        data: frame.bytes().to_vec(),
    }
}
