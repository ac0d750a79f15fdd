//! Where the robot and everything else really is: what a simulator, or a motion-capture system in
//! its place, publishes on `odom` and `scene`. Only pictures need it; no policy ever sees it.

use std::time::Duration;

use ros_interfaces::{
    builtin_interfaces::Time,
    geometry_msgs::{Point, Pose as PoseMessage},
    nav_msgs::Odometry,
    visualization_msgs::{Marker, MarkerArray},
};
use ros_runtime::{
    Node,
    node::{NodeError, Subscription, reliable},
};

use super::name_in;
use report::escape::{Pose, Scene, Shape};

/// How long to wait for the messages of an image. They are sent with it, but a scene at most every
/// 33 ms.
const PATIENCE: Duration = Duration::from_secs(1);

/// A reader of both.
pub struct GroundTruth<'a> {
    node: &'a Node,
    odometry: Subscription<Odometry>,
    scenes: Subscription<MarkerArray>,
}

impl<'a> GroundTruth<'a> {
    /// Begins to read the topics in a namespace, which is relative to the node's own.
    pub fn new(node: &'a Node, namespace: &str) -> Result<GroundTruth<'a>, NodeError> {
        let name = |name: &str| name_in(namespace, name);
        Ok(GroundTruth {
            node,
            odometry: node.create_subscription(&name("odom"), reliable(100))?,
            scenes: node.create_subscription(&name("scene"), reliable(100))?,
        })
    }

    /// Where the robot was, and what stood around it, when an image with that stamp was taken; `None`
    /// if nobody says so.
    pub fn at(&self, stamp: Time) -> Option<(Pose, Scene)> {
        let both = async {
            let pose = loop {
                let (odometry, _) = self.odometry.async_take().await.ok()?;
                if odometry.header.stamp == stamp {
                    break pose(&odometry.pose.pose);
                }
            };
            let scene = loop {
                let (scene, _) = self.scenes.async_take().await.ok()?;
                if scene.markers.last().is_some_and(|marker| marker.header.stamp == stamp) {
                    break scene_of(&scene);
                }
            };
            Some((pose, scene))
        };
        self.node.block_on(async { tokio::time::timeout(PATIENCE, both).await.ok().flatten() })
    }
}

fn pose(message: &PoseMessage) -> Pose {
    let [x, y] = plan(message, [0.0, 0.0]);
    Pose { x, y, yaw: yaw(message) }
}

/// The turn about the vertical axis.
fn yaw(pose: &PoseMessage) -> f64 {
    let q = &pose.orientation;
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

/// A point of a thing's own ground plan, on the floor of the room.
fn plan(pose: &PoseMessage, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = yaw(pose).sin_cos();
    let position = &pose.position;
    [position.x + cosine * x - sine * y, position.y + sine * x + cosine * y]
}

fn scene_of(message: &MarkerArray) -> Scene {
    let of = |namespace: &str| {
        let markers = message.markers.iter().filter(|marker| marker.ns == namespace);
        markers.flat_map(shapes).collect()
    };
    Scene { exit: of("exit"), obstacles: of("obstacles") }
}

/// The ground plan of a marker, in as many pieces as it has.
fn shapes(marker: &Marker) -> Vec<Shape> {
    let corner = |point: [f64; 2]| plan(&marker.pose, point);
    match marker.r#type {
        Marker::CYLINDER => {
            vec![Shape::Circle { centre: corner([0.0, 0.0]), radius: marker.scale.x / 2.0 }]
        }
        Marker::CUBE => {
            let (x, y) = (marker.scale.x / 2.0, marker.scale.y / 2.0);
            let corners = [[x, y], [-x, y], [-x, -y], [x, -y]];
            vec![Shape::Polygon(corners.map(corner).to_vec())]
        }
        Marker::TRIANGLE_LIST => {
            let on_the_floor = |point: &Point| corner([point.x, point.y]);
            let triangles = marker.points.chunks_exact(3);
            let plans = triangles.map(|points| points.iter().map(on_the_floor).collect());
            plans.filter(|plan: &Vec<[f64; 2]>| !is_upright(plan)).map(Shape::Polygon).collect()
        }
        _ => Vec::new(),
    }
}

/// Whether a triangle stands on the floor like a wall, and covers nothing of it.
fn is_upright(corners: &[[f64; 2]]) -> bool {
    let [a, b, c] = [corners[0], corners[1], corners[2]];
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    area.abs() < 1e-9
}

#[cfg(test)]
mod tests {
    use ros_interfaces::geometry_msgs::{Quaternion, Vector3};

    use super::*;

    #[test]
    fn markers_become_their_ground_plans() {
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
        // Turned by 90 degrees: what was deep is wide.
        let Shape::Polygon(corners) = &scene.exit[0] else { panic!("{scene:?}") };
        for (corner, expected) in corners.iter().zip([[0.75, 0.6], [0.75, 0.4], [1.25, 0.4]]) {
            assert!((corner[0] - expected[0]).hypot(corner[1] - expected[1]) < 1e-12, "{corner:?}");
        }
        // Of the concave wall, only the top has an area.
        let top = Shape::Polygon(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(scene.obstacles, [top]);
    }
}
