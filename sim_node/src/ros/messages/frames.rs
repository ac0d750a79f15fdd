//! Where things are: the frames of tf, odometry and the path.

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
use crate::{camera::CameraSettings, ros::session::Visit};

/// Where the robot is: odom -> base_link.
pub(crate) fn robot(robot: &Isometry2<f64>, stamp: Time) -> TFMessage {
    let Pose { position: Point { x, y, z }, orientation } = pose(robot, 0.0);
    let translation = Vector3 { x, y, z };
    TFMessage { transforms: vec![child(ODOM, BASE, translation, orientation, stamp)] }
}

/// Where the camera is on the robot: base_link -> camera_link -> camera_optical_frame.
pub(crate) fn mount(settings: &CameraSettings, stamp: Time) -> TFMessage {
    let &CameraSettings { forward, left, height, pitch } = settings;
    let pitched = UnitQuaternion::from_axis_angle(&Vector::y_axis(), pitch);
    // The optical z is the camera's x, the optical x its -y, and the optical y its -z.
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

/// The robot's pose, without error.
///
/// The twist is zero: the robot jumps from pose to pose as a chess piece does, and stands still
/// whenever it is looked at. A speed would be that of a movement that nobody simulates.
pub(crate) fn odometry(robot: &Isometry2<f64>, stamp: Time) -> Odometry {
    Odometry {
        header: header(ODOM, stamp),
        child_frame_id: BASE.to_owned(),
        pose: PoseWithCovariance { pose: pose(robot, 0.0), covariance: [0.0; 36] },
        twist: TwistWithCovariance::default(),
    }
}

/// The poses of an episode: the one it began with, and that after each step, a blocked one included.
pub(crate) fn path(visits: &[Visit], now: Time) -> Path {
    let poses = visits.iter().map(|visit| PoseStamped {
        header: header(ODOM, stamp(visit.time)),
        pose: pose(&visit.pose, 0.0),
    });
    Path { header: header(ODOM, now), poses: poses.collect() }
}

/// A pose in the ground plan, lifted to a height.
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
