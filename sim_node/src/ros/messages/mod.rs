//! Conversion of the world to ROS messages.

mod camera;
mod frames;
mod scene;
#[cfg(test)]
mod tests;

use ros_interfaces::{builtin_interfaces::Time, std_msgs::Header};

pub(super) use camera::{camera_info, image};
pub use frames::StampedPose;
pub(super) use frames::{mount, odometry, path, robot};
pub(super) use scene::scene;

/// The frame of the room; its origin is the centre of the floor. There is no frame `map`, because
/// the transform from `odom` to the robot does not drift.
const ODOM: &str = "odom";
/// The frame of the robot; its origin is the centre of the footprint, on the floor.
const BASE: &str = "base_link";
/// The frame of the camera with body axes (REP-103): x forward, y left, z up.
const CAMERA: &str = "camera_link";
/// The frame of the camera with optical axes (REP-103): z forward, x right, y down.
const OPTICAL: &str = "camera_optical_frame";

/// Converts simulated time in nanoseconds to a stamp.
pub(super) fn stamp(nanoseconds: u64) -> Time {
    const SECOND: u64 = 1_000_000_000;
    // builtin_interfaces/Time overflows after 68 years.
    let sec = i32::try_from(nanoseconds / SECOND).unwrap_or(i32::MAX);
    Time { sec, nanosec: (nanoseconds % SECOND) as u32 }
}

/// Converts a stamp to nanoseconds; negative seconds count as 0.
pub(super) fn nanoseconds(stamp: Time) -> u64 {
    u64::try_from(stamp.sec).unwrap_or(0) * 1_000_000_000 + u64::from(stamp.nanosec)
}

fn header(frame: &str, stamp: Time) -> Header {
    Header { stamp, frame_id: frame.to_owned() }
}
