//! The world's words as ROS messages.

mod camera;
mod frames;
mod scene;
#[cfg(test)]
mod tests;

use ros_interfaces::{builtin_interfaces::Time, std_msgs::Header};

pub(super) use camera::{camera_info, image};
pub(super) use frames::{mount, odometry, path, robot};
pub(super) use scene::scene;

/// The room: its origin is the middle of the floor. Nobody needs a frame `map` above it, because this
/// robot's odometry does not drift.
const ODOM: &str = "odom";
/// The robot: the middle of its footprint, on the floor.
const BASE: &str = "base_link";
/// The camera, as the body of the robot counts its axes: x ahead, y left, z up.
const CAMERA: &str = "camera_link";
/// The camera, as images count theirs (REP-103): z ahead, x right, y down.
const OPTICAL: &str = "camera_optical_frame";

/// The time of the simulation as a stamp.
pub(super) fn stamp(nanoseconds: u64) -> Time {
    const SECOND: u64 = 1_000_000_000;
    // builtin_interfaces/Time ends after 68 years.
    let sec = i32::try_from(nanoseconds / SECOND).unwrap_or(i32::MAX);
    Time { sec, nanosec: (nanoseconds % SECOND) as u32 }
}

/// A stamp as nanoseconds; one before the start is the start.
pub(super) fn nanoseconds(stamp: Time) -> u64 {
    u64::try_from(stamp.sec).unwrap_or(0) * 1_000_000_000 + u64::from(stamp.nanosec)
}

fn header(frame: &str, stamp: Time) -> Header {
    Header { stamp, frame_id: frame.to_owned() }
}
