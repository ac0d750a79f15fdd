//! The ground truth from the topics `tf` and `scene`: the poses of the robot, exit and obstacles.
//!
//! It is published by a simulator or a motion-capture system and used only for figures, never as an
//! input to a policy.

use std::time::Duration;

use ros_interfaces::{
    builtin_interfaces::Time,
    geometry_msgs::{Point, Pose as PoseMessage, Transform},
    tf2_msgs::TFMessage,
    visualization_msgs::{Marker, MarkerArray},
};
use ros_runtime::{
    Node,
    node::{NodeError, Subscription, reliable},
};

use super::name_in;
use report::escape::{Pose, Scene, Shape};

/// Timeout for receiving the messages with the stamp of an image. The simulator publishes `tf`
/// with each image, but `scene` at most every 33 ms.
const TIMEOUT: Duration = Duration::from_secs(1);

/// The frame of the robot.
const BASE: &str = "base_link";

/// Subscriptions to `tf` and `scene`. The transform from `odom` to `base_link` is the true pose;
/// the topic `odom` may have errors.
pub struct GroundTruth<'a> {
    node: &'a Node,
    transforms: Subscription<TFMessage>,
    scenes: Subscription<MarkerArray>,
}

impl<'a> GroundTruth<'a> {
    /// Subscribes to the topics in `namespace`, which is relative to the namespace of `node`.
    ///
    /// # Errors
    ///
    /// Returns an error if a subscription cannot be created.
    pub fn new(node: &'a Node, namespace: &str) -> Result<GroundTruth<'a>, NodeError> {
        let name = |name: &str| name_in(namespace, name);
        Ok(GroundTruth {
            node,
            transforms: node.create_subscription(&name("tf"), reliable(100))?,
            scenes: node.create_subscription(&name("scene"), reliable(100))?,
        })
    }

    /// Returns the pose of the robot at the stamp of an image. Blocks until the message has arrived;
    /// returns `None` after a timeout of 1 s or if the message is invalid.
    pub fn pose_at(&self, stamp: Time) -> Option<Pose> {
        let pose = async {
            loop {
                let (message, _) = self.transforms.async_take().await.ok()?;
                let robot = message.transforms.iter().find(|transform| {
                    transform.child_frame_id == BASE && transform.header.stamp == stamp
                });
                if let Some(robot) = robot {
                    return Some(pose(&robot.transform));
                }
            }
        };
        self.node.block_on(async { tokio::time::timeout(TIMEOUT, pose).await.ok().flatten() })
    }

    /// Like [`GroundTruth::pose_at`], for the scene. The simulator publishes it at most 30 times per
    /// second, so the matching scene may arrive up to 33 ms late.
    pub fn scene_at(&self, stamp: Time) -> Option<Scene> {
        let scene = async {
            loop {
                let (scene, _) = self.scenes.async_take().await.ok()?;
                if scene.markers.last().is_some_and(|marker| marker.header.stamp == stamp) {
                    return Some(scene_of(&scene));
                }
            }
        };
        self.node.block_on(async { tokio::time::timeout(TIMEOUT, scene).await.ok().flatten() })
    }
}

fn pose(transform: &Transform) -> Pose {
    let position = &transform.translation;
    let message = PoseMessage {
        position: Point { x: position.x, y: position.y, z: position.z },
        orientation: transform.rotation,
    };
    Pose { x: position.x, y: position.y, yaw: yaw(&message) }
}

/// Returns the rotation about the z axis, in radians.
fn yaw(pose: &PoseMessage) -> f64 {
    let q = &pose.orientation;
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

/// Transforms a point `[x, y]`, in metres, from the frame that `pose` defines to the frame in which
/// `pose` is given. Only the position and yaw of the pose are used.
fn transform(pose: &PoseMessage, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = yaw(pose).sin_cos();
    let position = &pose.position;
    [position.x + cosine * x - sine * y, position.y + sine * x + cosine * y]
}

fn scene_of(message: &MarkerArray) -> Scene {
    let shapes_in = |namespace: &str| {
        let markers = message.markers.iter().filter(|marker| marker.ns == namespace);
        markers.flat_map(shapes).collect()
    };
    Scene { exit: shapes_in("exit"), obstacles: shapes_in("obstacles") }
}

/// Returns the vertical projection of a marker onto the floor, as zero or more shapes.
fn shapes(marker: &Marker) -> Vec<Shape> {
    let project = |point: [f64; 2]| transform(&marker.pose, point);
    match marker.r#type {
        Marker::CYLINDER => {
            vec![Shape::Circle { centre: project([0.0, 0.0]), radius: marker.scale.x / 2.0 }]
        }
        Marker::CUBE => {
            let (x, y) = (marker.scale.x / 2.0, marker.scale.y / 2.0);
            let corners = [[x, y], [-x, y], [-x, -y], [x, -y]];
            vec![Shape::Polygon(corners.map(project).to_vec())]
        }
        Marker::TRIANGLE_LIST => {
            let project_point = |point: &Point| project([point.x, point.y]);
            let triangles = marker.points.chunks_exact(3);
            let projected = triangles.map(|points| points.iter().map(project_point).collect());
            projected
                .filter(|corners: &Vec<[f64; 2]>| !is_degenerate(corners))
                .map(Shape::Polygon)
                .collect()
        }
        _ => Vec::new(),
    }
}

/// Returns whether a projected triangle has no area, like the projection of a vertical face.
fn is_degenerate(corners: &[[f64; 2]]) -> bool {
    let [a, b, c] = [corners[0], corners[1], corners[2]];
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    area.abs() < 1e-9
}

#[cfg(test)]
mod tests {
    use ros_interfaces::geometry_msgs::{Quaternion, Vector3};

    use super::*;

    #[test]
    fn converts_markers_to_their_floor_projections() {
        let (sine, cosine) = std::f64::consts::FRAC_PI_4.sin_cos();
        let orientation = Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine };
        let position = Point { x: 1.0, y: 0.5, z: 0.1 };
        let scale = Vector3 { x: 0.2, y: 0.5, z: 1.0 };
        let pose = PoseMessage { position, orientation };
        assert!((yaw(&pose) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let cube =
            Marker { r#type: Marker::CUBE, ns: "exit".into(), pose, scale, ..Marker::default() };
        let wall = Marker {
            r#type: Marker::TRIANGLE_LIST,
            ns: "obstacles".into(),
            points: [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]]
                .into_iter()
                .chain([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
                .map(|[x, y, z]| Point { x, y, z })
                .collect(),
            ..Marker::default()
        };
        let scene = scene_of(&MarkerArray { markers: vec![cube, wall] });
        // The pose is rotated by 90 degrees, which swaps width and depth.
        let Shape::Polygon(corners) = &scene.exit[0] else { panic!("{scene:?}") };
        for (corner, expected) in corners.iter().zip([[0.75, 0.6], [0.75, 0.4], [1.25, 0.4]]) {
            assert!((corner[0] - expected[0]).hypot(corner[1] - expected[1]) < 1e-12, "{corner:?}");
        }
        // Only the top face of the concave wall has a projection of nonzero area.
        let top = Shape::Polygon(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(scene.obstacles, [top]);
    }
}
