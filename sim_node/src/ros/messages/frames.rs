//! Coordinate frames, odometry and path.

use nalgebra::{Isometry2, UnitQuaternion, Vector3 as Vector};
use ros_interfaces::{
    builtin_interfaces::Time,
    geometry_msgs::{
        Point, Pose, PoseStamped, PoseWithCovariance, Quaternion, Transform, TransformStamped,
        TwistWithCovariance, Vector3,
    },
    nav_msgs::{Odometry, Path},
    tf2_msgs::TFMessage,
};

use super::{BASE, CAMERA, ODOM, OPTICAL, header, stamp};
use crate::{camera::CameraSettings, reality::Odometry as Estimate};

/// A pose of the robot with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampedPose {
    /// Simulated time in nanoseconds.
    pub time: u64,
    /// Pose of the robot's centre, in metres and radians.
    pub pose: Isometry2<f64>,
}

/// Returns the transform odom -> base_link for the robot's pose.
pub(crate) fn robot(robot: &Isometry2<f64>, stamp: Time) -> TFMessage {
    let Pose { position: Point { x, y, z }, orientation } = pose(robot, 0.0);
    let translation = Vector3 { x, y, z };
    TFMessage { transforms: vec![child(ODOM, BASE, translation, orientation, stamp)] }
}

/// Returns the static transforms base_link -> camera_link -> camera_optical_frame.
pub(crate) fn mount(settings: &CameraSettings, stamp: Time) -> TFMessage {
    let &CameraSettings { forward, left, height, pitch } = settings;
    let pitched = UnitQuaternion::from_axis_angle(&Vector::y_axis(), pitch);
    // The optical axes x, y and z are -y, -z and x of camera_link.
    let optical = Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 };
    TFMessage {
        transforms: vec![
            child(
                BASE,
                CAMERA,
                Vector3 { x: forward, y: left, z: height },
                quaternion(&pitched),
                stamp,
            ),
            child(CAMERA, OPTICAL, Vector3::default(), optical, stamp),
        ],
    }
}

/// Returns the odometry of the robot.
///
/// The twist is zero because the robot changes its pose instantaneously and is at rest at every
/// stamp.
pub(crate) fn odometry(odometry: &Estimate, stamp: Time) -> Odometry {
    // A row-major 6 x 6 matrix over x, y, z and the rotations about these axes.
    let mut covariance = [0.0; 36];
    let plane = odometry.covariance();
    for (row, to_row) in [0, 1, 5].into_iter().enumerate() {
        for (column, to_column) in [0, 1, 5].into_iter().enumerate() {
            covariance[6 * to_row + to_column] = plane[(row, column)];
        }
    }
    Odometry {
        header: header(ODOM, stamp),
        child_frame_id: BASE.to_owned(),
        pose: PoseWithCovariance { pose: pose(&odometry.pose, 0.0), covariance },
        twist: TwistWithCovariance::default(),
    }
}

/// Returns the path of an episode: the start pose and the pose after each step, including blocked
/// steps.
pub(crate) fn path(poses: &[StampedPose], now: Time) -> Path {
    let poses = poses.iter().map(|stamped| PoseStamped {
        header: header(ODOM, stamp(stamped.time)),
        pose: pose(&stamped.pose, 0.0),
    });
    Path { header: header(ODOM, now), poses: poses.collect() }
}

/// Converts a pose in the ground plan to a pose at this height, in metres.
pub(super) fn pose(plan: &Isometry2<f64>, height: f64) -> Pose {
    let yaw = UnitQuaternion::from_axis_angle(&Vector::z_axis(), plan.rotation.angle());
    Pose {
        position: Point { x: plan.translation.x, y: plan.translation.y, z: height },
        orientation: quaternion(&yaw),
    }
}

fn quaternion(rotation: &UnitQuaternion<f64>) -> Quaternion {
    Quaternion { x: rotation.i, y: rotation.j, z: rotation.k, w: rotation.w }
}

fn child(
    parent: &str,
    name: &str,
    translation: Vector3,
    rotation: Quaternion,
    stamp: Time,
) -> TransformStamped {
    TransformStamped {
        header: header(parent, stamp),
        child_frame_id: name.to_owned(),
        transform: Transform { translation, rotation },
    }
}
