//! Compares the messages with the world and the camera.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{
    Isometry2, Isometry3, Point3, Quaternion as Parts, Translation3, UnitQuaternion, Vector2,
    Vector3,
};
use ros_interfaces::{
    geometry_msgs::{Point, Pose, Quaternion, TransformStamped},
    visualization_msgs::{Marker, MarkerArray},
};
use task::Scenario;

use super::*;
use crate::{
    Simulation,
    camera::{Camera, CameraSettings, WIDTH, equidistant::DISTORTION, lens},
    reality::{Conditions, Odometry, Reality},
    ros::messages::StampedPose,
    world::{Layout, World, WorldSettings},
};

const NOW: Time = Time { sec: 3, nanosec: 500_000_000 };

/// Returns a world with a fixed layout, in the format of the parameters `fixed_*`.
fn fixed_world(scenario: Scenario, exit: &[f64], cylinders: &[f64], robot: &[f64]) -> World {
    let layout = Layout::from_lists(exit, cylinders, robot).unwrap();
    World::new(WorldSettings { layout, ..WorldSettings::default() }, scenario, 0).unwrap()
}

/// Converts a quaternion and asserts that its length is 1.
fn rotation(quaternion: &Quaternion) -> UnitQuaternion<f64> {
    let &Quaternion { x, y, z, w } = quaternion;
    let parts = Parts::new(w, x, y, z);
    assert!((parts.norm() - 1.0).abs() < 1e-15, "{quaternion:?}");
    UnitQuaternion::new_unchecked(parts)
}

fn isometry(position: [f64; 3], orientation: &Quaternion) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(position), rotation(orientation))
}

fn of_pose(Pose { position: Point { x, y, z }, orientation }: &Pose) -> Isometry3<f64> {
    isometry([*x, *y, *z], orientation)
}

fn of_transform(message: &TransformStamped) -> Isometry3<f64> {
    let translation = message.transform.translation;
    let position = [translation.x, translation.y, translation.z];
    isometry(position, &message.transform.rotation)
}

fn assert_close(actual: Vector3<f64>, expected: Vector3<f64>) {
    assert!((actual - expected).norm() < 1e-14, "{actual}, expected {expected}");
}

#[test]
fn a_stamp_splits_nanoseconds_and_saturates() {
    assert_eq!(stamp(3_500_000_000), NOW);
    assert_eq!(stamp(0), Time::default());
    assert_eq!(stamp(u64::MAX).sec, i32::MAX);
}

#[test]
fn the_frames_form_a_chain_from_odom_to_the_optical_frame() {
    let robot = robot(&Isometry2::new(Vector2::new(0.5, -0.25), 1.0), NOW);
    let mount = mount(&CameraSettings::default(), NOW);
    let links: Vec<(&str, &str)> = robot
        .transforms
        .iter()
        .chain(&mount.transforms)
        .map(|link| (link.header.frame_id.as_str(), link.child_frame_id.as_str()))
        .collect();
    assert_eq!(
        links,
        [
            ("odom", "base_link"),
            ("base_link", "camera_link"),
            ("camera_link", "camera_optical_frame"),
        ]
    );
    let stamps = robot.transforms.iter().chain(&mount.transforms).map(|link| link.header.stamp);
    assert!(stamps.into_iter().all(|stamp| stamp == NOW));
}

/// The direction of each pixel in the optical frame, transformed by tf, must be the ray that the
/// renderer casts for it; the origin of the frame must be the renderer's eye.
#[test]
fn the_optical_frame_matches_the_eye_of_the_renderer() {
    let tilted = CameraSettings { forward: 0.05, left: -0.07, height: 0.2, pitch: 0.4 };
    let up = CameraSettings { pitch: -FRAC_PI_2, ..CameraSettings::default() };
    for settings in [CameraSettings::default(), tilted, up] {
        for pose in [[0.0, 0.0, 0.0], [0.5, -0.25, 1.0], [-0.3, 0.8, PI], [0.1, 0.2, -3.0]] {
            let world = fixed_world(Scenario::Empty, &[1.0, -1.0], &[], &pose);
            let camera = Camera::new(settings).unwrap();
            let mount = mount(&settings, NOW);
            let robot = robot(world.robot(), NOW);
            let links = robot.transforms.iter().chain(&mount.transforms);
            let optical = links.map(of_transform).fold(Isometry3::identity(), |a, b| a * b);

            let eye = camera.eye(&world);
            let position = eye.translation.vector.push(settings.height);
            assert_close(optical.translation.vector, position);
            for ray in camera.rays() {
                let ahead = lens::direction(ray.pixel % WIDTH, ray.pixel / WIDTH);
                let direction = Vector3::new(-ahead.y, -ahead.z, ahead.x);
                let cast = (eye.rotation * ray.direction.xy()).push(ray.direction.z);
                assert_close(optical.rotation * direction, cast);
            }
            // The optical axis, calculated by hand.
            let (sine, cosine) = settings.pitch.sin_cos();
            let axis = (eye.rotation * Vector2::new(cosine, 0.0)).push(-sine);
            assert_close(optical.rotation * Vector3::z(), axis);
        }
    }
}

#[test]
fn odometry_has_the_estimated_pose_and_covariance() {
    let pose = Isometry2::new(Vector2::new(0.5, -0.25), 2.5);
    let mut reality = Reality::default();
    (reality.odometry.noise, reality.odometry.drift) = (0.05, 0.02);
    let mut estimate = Odometry::at(Isometry2::new(Vector2::new(0.5, -0.25), 2.0));
    estimate.follow(&estimate.pose.clone(), &pose, &Conditions::draw(&reality, 1), 1);
    let plane = estimate.covariance();
    estimate.pose = pose;
    let message = odometry(&estimate, NOW);
    assert_eq!(message.header, Header { stamp: NOW, frame_id: "odom".to_owned() });
    assert_eq!(message.child_frame_id, "base_link");
    let Point { x, y, z } = message.pose.pose.position;
    assert_eq!((x, y, z), (0.5, -0.25, 0.0));
    let (roll, pitch, yaw) = rotation(&message.pose.pose.orientation).euler_angles();
    assert!(roll.abs() < 1e-15 && pitch.abs() < 1e-15 && (yaw - 2.5).abs() < 1e-15);
    let covariance = message.pose.covariance;
    assert!(covariance[35] > 0.0 && covariance[35] == plane[(2, 2)]);
    assert_eq!((covariance[0], covariance[7]), (plane[(0, 0)], plane[(1, 1)]));
    assert_eq!((covariance[5], covariance[31]), (plane[(0, 2)], plane[(2, 1)]));
    assert_eq!(covariance[14], 0.0, "z is exact");
    assert_eq!(message.twist, Default::default());
}

#[test]
fn a_path_has_the_stamp_and_position_of_every_pose() {
    let poses = [(500_000_000, 0.1), (1_000_000_000, 0.2)]
        .map(|(time, x)| StampedPose { time, pose: Isometry2::translation(x, 0.0) });
    let message = path(&poses, NOW);
    assert_eq!(message.header, Header { stamp: NOW, frame_id: "odom".to_owned() });
    let found: Vec<(Header, f64)> =
        message.poses.into_iter().map(|pose| (pose.header, pose.pose.position.x)).collect();
    let expected = [(0, 500_000_000, 0.1), (1, 0, 0.2)]
        .map(|(sec, nanosec, x)| (header("odom", Time { sec, nanosec }), x));
    assert_eq!(found, expected);
}

#[test]
fn camera_info_matches_its_image() {
    let world = fixed_world(Scenario::Empty, &[], &[], &[]);
    let camera = Camera::new(CameraSettings::default()).unwrap();
    let simulation = Simulation::new(world, camera);
    let (image, info) = (image(&simulation, 0, NOW), camera_info(NOW));
    assert_eq!(info.header, image.header);
    assert_eq!(info.header, Header { stamp: NOW, frame_id: "camera_optical_frame".to_owned() });
    assert_eq!((info.width, info.height), (image.width, image.height));
    assert_eq!(info.distortion_model, "equidistant");
    assert_eq!(info.d, DISTORTION);
    assert_eq!(info.k, [5.0, 0.0, 9.5, 0.0, 5.0, 3.0, 0.0, 0.0, 1.0]);
    assert_eq!(info.p, [5.0, 0.0, 9.5, 0.0, 0.0, 5.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
}

/// Returns the markers of a namespace.
fn of<'scene>(scene: &'scene MarkerArray, namespace: &str) -> Vec<&'scene Marker> {
    scene.markers[1..].iter().filter(|marker| marker.ns == namespace).collect()
}

/// Returns the corners of a box with the smallest and the largest coordinates.
fn extent(marker: &Marker) -> [[f64; 3]; 2] {
    assert_eq!(marker.r#type, Marker::CUBE);
    let pose = of_pose(&marker.pose);
    let half = Vector3::new(marker.scale.x, marker.scale.y, marker.scale.z) / 2.0;
    let (first, second) = (pose * Point3::from(-half), pose * Point3::from(half));
    let rounded = |number: f64| (number * 1e9).round() / 1e9 + 0.0;
    [first.inf(&second), first.sup(&second)].map(|corner| corner.coords.map(rounded).into())
}

#[test]
fn a_scene_deletes_earlier_markers_and_has_unique_marker_ids() {
    for scenario in Scenario::ALL {
        let scene = scene(&fixed_world(scenario, &[], &[], &[]), NOW);
        assert_eq!(scene.markers[0].action, Marker::DELETEALL);
        let mut ids: Vec<(&str, i32)> =
            scene.markers[1..].iter().map(|marker| (marker.ns.as_str(), marker.id)).collect();
        ids.sort();
        let count = ids.len();
        ids.dedup();
        assert_eq!(ids.len(), count, "{scenario}: duplicate marker id");
        let obstacles = scenario.cylinders() + usize::from(scenario.has_concave_wall());
        assert_eq!(of(&scene, "obstacles").len(), obstacles, "{scenario}");
        assert_eq!(count, 5 + 1 + obstacles + 2, "{scenario}");
        for marker in &scene.markers {
            assert_eq!(marker.header, Header { stamp: NOW, frame_id: "odom".to_owned() });
            rotation(&marker.pose.orientation);
        }
    }
}

#[test]
fn the_room_is_a_floor_surrounded_by_four_walls() {
    let scene = scene(&fixed_world(Scenario::Empty, &[], &[], &[]), NOW);
    let room = of(&scene, "room");
    let extents: Vec<[[f64; 3]; 2]> = room.iter().map(|marker| extent(marker)).collect();
    assert_eq!(
        extents,
        [
            [[-1.25, -1.25, -0.01], [1.25, 1.25, 0.0]],
            [[1.25, -1.3, 0.0], [1.3, 1.3, 1.0]],
            [[-1.25, 1.25, 0.0], [1.25, 1.3, 1.0]],
            [[-1.3, -1.3, 0.0], [-1.25, 1.3, 1.0]],
            [[-1.25, -1.3, 0.0], [1.25, -1.25, 1.0]],
        ]
    );
    let colours: Vec<[f32; 3]> = room.iter().map(|m| [m.color.r, m.color.g, m.color.b]).collect();
    assert_eq!(colours[0], [0.5; 3]);
    assert_eq!(colours[1..], [[0.0, 0.0, 1.0]; 4]);
}

#[test]
fn markers_have_the_poses_of_exit_robot_and_cylinders() {
    let cylinders = [0.5, 0.5, -0.5, 0.5];
    let robot = [0.25, -0.5, FRAC_PI_2];
    let scene = scene(&fixed_world(Scenario::TwoCylinders, &[1.0, 0.5], &cylinders, &robot), NOW);
    let exit = of(&scene, "exit")[0];
    assert_eq!(extent(exit), [[0.25, 1.15, 0.0], [0.75, 1.35, 1.0]]);
    assert_eq!([exit.color.r, exit.color.g, exit.color.b, exit.color.a], [0.0, 1.0, 0.0, 1.0]);
    for (marker, centre) in of(&scene, "obstacles").into_iter().zip([(0.5, 0.5), (-0.5, 0.5)]) {
        assert_eq!(marker.r#type, Marker::CYLINDER);
        assert_eq!((marker.pose.position.x, marker.pose.position.y), centre);
        assert_eq!(marker.pose.position.z, 0.15);
        assert_eq!((marker.scale.x, marker.scale.y, marker.scale.z), (0.3048, 0.3048, 0.3));
        assert_eq!([marker.color.r, marker.color.g, marker.color.b], [1.0, 0.0, 0.0]);
    }
    let [body, heading] = of(&scene, "robot")[..] else { panic!("expected a body and an arrow") };
    assert_eq!(extent(body), [[0.175, -0.575, 0.0], [0.325, -0.425, 0.1]]);
    assert_eq!(heading.r#type, Marker::ARROW);
    assert_close(of_pose(&heading.pose) * Vector3::x(), Vector3::y());
}

/// Together with the floor, the triangles must enclose the volume of the wall.
#[test]
fn the_concave_wall_is_drawn_as_a_closed_solid() {
    let world = fixed_world(Scenario::Concave, &[], &[], &[]);
    let scene = scene(&world, NOW);
    let wall = of(&scene, "obstacles")[0];
    assert_eq!((wall.r#type, wall.pose), (Marker::TRIANGLE_LIST, Pose::default()));
    assert_eq!((wall.scale.x, wall.scale.y, wall.scale.z), (1.0, 1.0, 1.0));
    assert_eq!([wall.color.r, wall.color.g, wall.color.b, wall.color.a], [1.0, 0.0, 0.0, 1.0]);

    let corners: Vec<Vector3<f64>> =
        wall.points.iter().map(|point| Vector3::new(point.x, point.y, point.z)).collect();
    let (triangles, rest) = corners.as_chunks::<3>();
    assert!(rest.is_empty());
    // Each triangle and the origin, which is on the floor, span a tetrahedron. The triple product
    // is six times its volume.
    let volume = triangles.iter().map(|[a, b, c]| a.cross(b).dot(c)).sum::<f64>() / 6.0;
    let top = triangles.iter().filter(|corners| corners.iter().all(|corner| corner.z == 0.25));
    let area = top.map(|[a, b, c]| (b - a).cross(&(c - a)).z).sum::<f64>() / 2.0;
    let outline = world.concave_wall().unwrap().outline();
    let plan = (0..outline.len())
        .map(|corner| {
            let (from, to) = (outline[corner], outline[(corner + 1) % outline.len()]);
            // The outline is clockwise.
            to.coords.perp(&from.coords) / 2.0
        })
        .sum::<f64>();
    assert!((area - plan).abs() < 1e-12, "area {area} m2, expected {plan}");
    assert!((volume - plan * 0.25).abs() < 1e-12, "volume {volume} m3, expected {}", plan * 0.25);
}
