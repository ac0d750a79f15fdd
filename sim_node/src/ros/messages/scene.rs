//! Visualization markers that show the room in RViz.

use nalgebra::{Isometry2, Point2, Translation2};
use ros_interfaces::{
    builtin_interfaces::Time,
    geometry_msgs::{Point, Pose, Vector3},
    std_msgs::ColorRGBA,
    std_msgs::Header,
    visualization_msgs::{Marker, MarkerArray},
};

use super::{ODOM, frames::pose, header};
use crate::{
    camera::light::{self, Colour},
    world::{
        CONCAVE_WALL_HEIGHT, CYLINDER_HEIGHT, CYLINDER_RADIUS, ConcaveWall, EXIT_DEPTH,
        EXIT_HEIGHT, EXIT_WIDTH, FOOTPRINT_SIDE, ROOM_SIDE, WALL_HEIGHT, Wall, World,
    },
};

/// Thickness of the drawn walls in metres. In the world, walls have no outer side.
const WALL_THICKNESS: f64 = 0.05;
/// Thickness of the drawn floor in metres. Its top is at height 0.
const FLOOR_THICKNESS: f64 = 0.01;
/// Opacity of the walls, low enough for the room to be visible from outside.
const WALL_OPACITY: f32 = 0.3;
/// Height of the drawn robot in metres. In the world, the robot has neither height nor colour.
const ROBOT_HEIGHT: f64 = 0.1;
/// Colour of the robot, unlike any other in the room.
const ROBOT: Colour = [1.0, 0.8, 0.0];
/// Size of the arrow that shows the heading, on top of the robot, in metres.
const HEADING: Vector3 = Vector3 { x: 0.2, y: 0.03, z: 0.03 };

/// Returns markers for everything in the room. The first marker deletes those of earlier scenes.
///
/// | namespace | markers |
/// |---|---|
/// | `room` | the floor, then the four walls counter-clockwise from +x |
/// | `exit` | the exit |
/// | `obstacles` | the cylinders, or the concave wall |
/// | `robot` | the robot, then the arrow that shows its heading |
pub(crate) fn scene(world: &World, stamp: Time) -> MarkerArray {
    let builder = MarkerBuilder { header: header(ODOM, stamp) };
    let clear =
        Marker { action: Marker::DELETEALL, header: builder.header.clone(), ..Marker::default() };
    let mut markers = vec![clear];
    markers.extend(builder.room());
    markers.push(builder.cuboid("exit", &world.exit().pose(), EXIT, light::EXIT));
    let size = [2.0 * CYLINDER_RADIUS, 2.0 * CYLINDER_RADIUS, CYLINDER_HEIGHT];
    for cylinder in world.cylinders() {
        let marker = builder.cuboid("obstacles", cylinder.pose(), size, light::OBSTACLE);
        markers.push(Marker { r#type: Marker::CYLINDER, ..marker });
    }
    markers.extend(world.concave_wall().map(|wall| builder.concave_wall(wall)));
    markers.extend(builder.robot(world.robot()));
    assign_ids(&mut markers[1..]);
    MarkerArray { markers }
}

/// Size of the exit in its own frame, in metres.
const EXIT: [f64; 3] = [EXIT_DEPTH, EXIT_WIDTH, EXIT_HEIGHT];

/// Numbers the markers of each namespace from 0. Markers of a namespace must be adjacent.
fn assign_ids(markers: &mut [Marker]) {
    for namespace in markers.chunk_by_mut(|first, second| first.ns == second.ns) {
        for (id, marker) in (0..).zip(namespace) {
            marker.id = id;
        }
    }
}

/// Creates the markers of one scene.
struct MarkerBuilder {
    header: Header,
}

impl MarkerBuilder {
    fn marker(&self, namespace: &str, kind: i32, pose: Pose, scale: Vector3, c: Colour) -> Marker {
        let [r, g, b] = c.map(|channel| channel as f32);
        Marker {
            header: self.header.clone(),
            ns: namespace.to_owned(),
            r#type: kind,
            action: Marker::ADD,
            pose,
            scale,
            color: ColorRGBA { r, g, b, a: 1.0 },
            ..Marker::default()
        }
    }

    /// Returns a box that stands on the floor, centred on a pose in the ground plan. `size` is in
    /// metres.
    fn cuboid(&self, namespace: &str, plan: &Isometry2<f64>, size: [f64; 3], c: Colour) -> Marker {
        let [x, y, z] = size;
        self.marker(namespace, Marker::CUBE, pose(plan, z / 2.0), Vector3 { x, y, z }, c)
    }

    fn room(&self) -> impl Iterator<Item = Marker> {
        let mut floor = self.cuboid(
            "room",
            &Isometry2::identity(),
            [ROOM_SIDE, ROOM_SIDE, FLOOR_THICKNESS],
            light::FLOOR,
        );
        floor.pose.position.z = -FLOOR_THICKNESS / 2.0;
        let walls = Wall::ALL.map(|wall| {
            // The walls towards ±x include the corners, so no two walls overlap.
            let length = match wall {
                Wall::PositiveX | Wall::NegativeX => ROOM_SIDE + 2.0 * WALL_THICKNESS,
                Wall::PositiveY | Wall::NegativeY => ROOM_SIDE,
            };
            let plan = wall.face(0.0) * Translation2::new(-WALL_THICKNESS / 2.0, 0.0);
            let size = [WALL_THICKNESS, length, WALL_HEIGHT];
            let mut marker = self.cuboid("room", &plan, size, light::WALL);
            marker.color.a = WALL_OPACITY;
            marker
        });
        [floor].into_iter().chain(walls)
    }

    fn concave_wall(&self, wall: &ConcaveWall) -> Marker {
        let unscaled = Vector3 { x: 1.0, y: 1.0, z: 1.0 };
        let kind = Marker::TRIANGLE_LIST;
        let marker = self.marker("obstacles", kind, Pose::default(), unscaled, light::OBSTACLE);
        Marker { points: triangles(wall), ..marker }
    }

    fn robot(&self, robot: &Isometry2<f64>) -> [Marker; 2] {
        let size = [FOOTPRINT_SIDE, FOOTPRINT_SIDE, ROBOT_HEIGHT];
        let above = pose(robot, ROBOT_HEIGHT + HEADING.z / 2.0);
        [
            self.cuboid("robot", robot, size, ROBOT),
            self.marker("robot", Marker::ARROW, above, HEADING, ROBOT),
        ]
    }
}

/// Returns the sides and the top of the concave wall as triangles in the frame of the room: three
/// corners each, counter-clockwise as seen from outside.
fn triangles(wall: &ConcaveWall) -> Vec<Point> {
    let outline = wall.outline();
    let last = outline.len() - 1;
    // The outline is clockwise, so the outside is on the left of each edge.
    let sides = (0..=last).flat_map(|corner| {
        let (from, to) = (&outline[corner], &outline[(corner + 1) % outline.len()]);
        let top = CONCAVE_WALL_HEIGHT;
        quadrilateral([at(to, 0.0), at(from, 0.0), at(from, top), at(to, top)])
    });
    let pieces = (0..outline.len() / 2 - 1).flat_map(|piece| {
        let corners = [piece + 1, piece, last - piece, last - piece - 1];
        quadrilateral(corners.map(|corner| at(&outline[corner], CONCAVE_WALL_HEIGHT)))
    });
    sides.chain(pieces).collect()
}

/// Returns the two triangles of a quadrilateral.
fn quadrilateral([a, b, c, d]: [Point; 4]) -> [Point; 6] {
    [a, b, c, a, c, d]
}

fn at(plan: &Point2<f64>, height: f64) -> Point {
    Point { x: plan.x, y: plan.y, z: height }
}
