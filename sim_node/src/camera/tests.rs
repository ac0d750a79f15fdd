//! Compares the renderer with images calculated by hand, with parry2d ray casts, and with golden
//! checksums.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::num::NonZeroU64;

use nalgebra::{Point2, UnitComplex, Vector3};
use parry2d::math::{Pose, Vector};
use parry2d::query::Ray;
use parry2d::shape::{Ball, Compound, ConvexPolygon, Cuboid, HalfSpace, Shape, SharedShape};
use proptest::prelude::*;
use task::{Action, Scenario};

use super::*;
use crate::world::{
    CONCAVE_WALL_HEIGHT, CYLINDER_HEIGHT, CYLINDER_RADIUS, EXIT_DEPTH, EXIT_HEIGHT, EXIT_WIDTH,
    Layout, WALL_HEIGHT, Wall, World, WorldSettings, contact,
};

const SKY: [u8; 3] = [179; 3];
const FLOOR: [u8; 3] = [128; 3];

/// Returns a world with a fixed layout, in the format of the parameters `fixed_*`.
fn fixed_world(scenario: Scenario, exit: &[f64], cylinders: &[f64], robot: &[f64]) -> World {
    let layout = Layout::from_lists(exit, cylinders, robot).unwrap();
    World::new(WorldSettings { layout, ..WorldSettings::default() }, scenario, 0).unwrap()
}

fn camera() -> Camera {
    Camera::new(CameraSettings::default()).unwrap()
}

/// Returns a column of the frame, from top to bottom.
fn column(frame: &Frame, column: usize) -> [[u8; 3]; HEIGHT] {
    std::array::from_fn(|row| frame.pixel(column, row))
}

// Elevation of the rows in the middle columns, from top to bottom: 33.3, 22.5, 11.4, 0, -11.4,
// -22.5 and -33.3 degrees. Azimuth of the columns in the middle row, from the middle outward: 5.7,
// 17.1, 28.1, ... degrees.

/// The robot is 0.5 m behind the centre of the room, so the wall ahead is 1.675 m from the eye: its
/// top is atan(0.91 / 1.675) = 28.5 degrees up and its foot atan(0.09 / 1.675) = 3.1 degrees down.
#[test]
fn the_middle_columns_show_sky_wall_and_floor() {
    // The brightness of each wall depends on its orientation to the light.
    for (ahead, x, y, brightness) in
        [(0.0, -0.5, 0.0, 102), (1.0, 0.0, -0.5, 122), (2.0, 0.5, 0.0, 201), (3.0, 0.0, 0.5, 102)]
    {
        let behind = (ahead + 2.0) % 4.0;
        let robot = [x, y, ahead * FRAC_PI_2];
        let frame = camera().render(&fixed_world(Scenario::Empty, &[behind, 0.0], &[], &robot));
        let wall = [0, 0, brightness];
        for middle in [9, 10] {
            assert_eq!(
                column(&frame, middle),
                [SKY, wall, wall, wall, FLOOR, FLOOR, FLOOR],
                "column {middle} towards wall {ahead}"
            );
        }
    }
}

/// The exit is 0.5 m wide and its face is 1.575 m from the eye: it extends atan(0.25 / 1.575) = 9
/// degrees to both sides and atan(0.91 / 1.575) = 30 degrees up.
#[test]
fn an_exit_ahead_is_green_in_the_middle_columns() {
    let world = fixed_world(Scenario::Empty, &[0.0, 0.0], &[], &[-0.5, 0.0, 0.0]);
    let frame = camera().render(&world);
    let (green, blue) = ([0, 102, 0], [0, 0, 102]);
    for middle in [9, 10] {
        assert_eq!(column(&frame, middle), [SKY, green, green, green, FLOOR, FLOOR, FLOOR]);
    }
    for outer in [8, 11] {
        assert_eq!(column(&frame, outer), [SKY, blue, blue, blue, FLOOR, FLOOR, FLOOR]);
    }
}

/// An exit 0.5 m to the left extends from 13.1 to 34.9 degrees to the left: it covers the columns
/// at 17.1 and 28.1 degrees, which are columns 8 and 7.
#[test]
fn an_exit_to_the_left_is_in_the_left_half() {
    let world = fixed_world(Scenario::Empty, &[0.0, 0.5], &[], &[0.0, 0.0, 0.0]);
    let frame = camera().render(&world);
    let green: Vec<usize> =
        (0..WIDTH).filter(|&column| frame.pixel(column, 3) == [0, 102, 0]).collect();
    assert_eq!(green, [7, 8]);
}

/// The front of the cylinder is 1.045 - 0.1524 = 0.8926 m from the eye: its top is
/// atan(0.21 / 0.8926) = 13.2 degrees up and its foot atan(0.09 / 0.8926) = 5.8 degrees down. It
/// extends asin(0.1524 / 1.045) = 8.4 degrees to both sides. Wall and sky remain visible above it
/// and at its sides.
#[test]
fn a_cylinder_ahead_hides_only_what_is_behind_it() {
    let world = fixed_world(Scenario::OneCylinder, &[2.0, 0.0], &[0.62, 0.0], &[-0.5, 0.0, 0.0]);
    let frame = camera().render(&world);
    // Its front faces -x, away from the light.
    let (red, blue) = ([102, 0, 0], [0, 0, 102]);
    for middle in [9, 10] {
        assert_eq!(column(&frame, middle), [SKY, blue, red, red, FLOOR, FLOOR, FLOOR]);
    }
    for outer in [8, 11] {
        assert_eq!(column(&frame, outer), [SKY, blue, blue, blue, FLOOR, FLOOR, FLOOR]);
    }
}

/// The normal of the cylinder at the middle columns is almost +x, so its brightness is almost that
/// of a face towards +x, which receives 0.48337 of the light and has brightness 201 of 255.
#[test]
fn a_cylinder_is_shaded_by_its_normal() {
    let robot = [0.0, 0.0, PI];
    let world = fixed_world(Scenario::OneCylinder, &[0.0, 0.0], &[-0.65, 0.0], &robot);
    let frame = camera().render(&world);
    // The ray 5.72 degrees to the right, which is +y here, hits the cylinder at an offset of
    // 0.0426 m: normal (0.960, 0.280), intensity
    // 0.4 + 0.8 * (0.48337 * 0.960 - 0.09667 * 0.280) = 0.7496.
    assert_eq!(frame.pixel(10, 3), [191, 0, 0]);
    // To the left: normal (0.960, -0.280), intensity 0.4 + 0.8 * (0.46404 + 0.02707) = 0.7929.
    assert_eq!(frame.pixel(9, 3), [202, 0, 0]);
}

/// Inside the concave wall, the inner face is on all sides except behind the robot. Ahead it is
/// 0.525 m from the eye and its top is atan(0.16 / 0.525) = 17 degrees up; the wall of the room is
/// visible above it.
#[test]
fn inside_the_concave_wall_the_middle_row_is_red() {
    let robot = [0.0, -0.35, FRAC_PI_2];
    let world = fixed_world(Scenario::Concave, &[3.0, 0.0], &[], &robot);
    let frame = camera().render(&world);
    for column in 0..WIDTH {
        let [red, green, blue] = frame.pixel(column, 3);
        assert!(red >= 102 && green == 0 && blue == 0, "column {column}");
    }
    assert_eq!(frame.pixel(9, 2)[1..], [0, 0]);
    assert_eq!(frame.pixel(9, 1), [0, 0, 122]);
}

/// From the origin, the wall ahead is 1.175 m from the eye: it extends from 4.4 degrees down to
/// 37.8 degrees up.
#[test]
fn a_positive_pitch_looks_down() {
    let world = fixed_world(Scenario::Empty, &[2.0, 0.0], &[], &[0.0, 0.0, 0.0]);
    let rows = |pitch| {
        let camera = Camera::new(CameraSettings { pitch, ..Default::default() }).unwrap();
        column(&camera.render(&world), 9)
    };
    // Pitched down, the top row looks 45 - 33.3 degrees down; pitched up, the bottom row looks up
    // by the same angle.
    assert_eq!(rows(FRAC_PI_4), [FLOOR; HEIGHT]);
    let wall = [0, 0, 102];
    assert_eq!(rows(-FRAC_PI_4), [SKY, SKY, SKY, SKY, wall, wall, wall]);
}

#[test]
fn a_camera_inside_the_exit_sees_only_green() {
    let mut world = fixed_world(Scenario::Empty, &[0.0, 0.0], &[], &[1.04, 0.0, 0.0]);
    assert!(world.step(Action::ALL[3]).unwrap().terminated);
    let frame = camera().render(&world);
    assert!(frame.bytes().as_chunks().0.iter().all(|pixel| *pixel == [0, 102, 0]));
}

/// Returns the solids of a world as parry shapes, with their poses and heights.
fn solids(world: &World) -> Vec<(Pose, Box<dyn Shape>, f64)> {
    let mut solids: Vec<(Pose, Box<dyn Shape>, f64)> = Vec::new();
    for wall in Wall::ALL {
        let solid = HalfSpace::new(Vector::X);
        solids.push((contact::pose(&wall.face(0.0)), Box::new(solid), WALL_HEIGHT));
    }
    let exit = Cuboid::new(Vector::new(EXIT_DEPTH as f32 / 2.0, EXIT_WIDTH as f32 / 2.0));
    solids.push((contact::pose(&world.exit().pose()), Box::new(exit), EXIT_HEIGHT));
    for cylinder in world.cylinders() {
        let solid = Ball::new(CYLINDER_RADIUS as f32);
        solids.push((contact::pose(cylinder.pose()), Box::new(solid), CYLINDER_HEIGHT));
    }
    if let Some(wall) = world.concave_wall() {
        let outline = wall.outline();
        let last = outline.len() - 1;
        let pieces = (0..outline.len() / 2 - 1).map(|piece| {
            let corners = [piece, piece + 1, last - piece - 1, last - piece];
            let corners = corners.map(|corner| contact::point(&outline[corner]));
            let piece = ConvexPolygon::from_convex_hull(&corners).unwrap();
            (Pose::identity(), SharedShape::new(piece))
        });
        let wall = Compound::new(pieces.collect());
        solids.push((Pose::identity(), Box::new(wall), CONCAVE_WALL_HEIGHT));
    }
    solids
}

/// Returns the distance, in metres, at which a ray hits the floor or a solid, computed with parry's
/// ray casts in the ground plan; infinite for the sky. All solids are raised by `slack` metres.
fn distance_by_parry(
    solids: &[(Pose, Box<dyn Shape>, f64)],
    eye: &Point2<f64>,
    eye_height: f64,
    direction: &Vector3<f64>,
    slack: f64,
) -> f64 {
    let level = direction.xy().norm();
    let heading = direction.xy() / level;
    let ray = Ray::new(contact::point(eye), Vector::new(heading.x as f32, heading.y as f32));
    let floor = if direction.z < 0.0 { -eye_height / direction.z } else { f64::INFINITY };
    solids
        .iter()
        .filter_map(|(pose, shape, height)| {
            let distance = f64::from(shape.cast_ray(pose, &ray, 100.0, true)?) / level;
            (eye_height + distance * direction.z <= height + slack).then_some(distance)
        })
        .fold(floor, f64::min)
}

fn scenarios() -> impl Strategy<Value = Scenario> {
    proptest::sample::select(Scenario::ALL.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// At an edge, parry's single precision may give a different result. A distance is therefore
    /// also accepted if it matches for a ray turned by 2e-5 radians, or for solids raised or
    /// lowered by 1e-5 m.
    #[test]
    fn distances_match_parry_ray_casts(
        seed in 1..u64::MAX,
        scenario in scenarios(),
        pitch in prop_oneof![Just(0.0), -1.5..1.5],
        height in 0.01..0.24,
        forward in -0.075..0.075,
        left in -0.075..0.075,
    ) {
        let settings = CameraSettings { forward, left, height, pitch };
        let camera = Camera::new(settings).unwrap();
        let world = World::new(WorldSettings::default(), scenario, seed).unwrap();
        let solids = solids(&world);
        let eye = camera.eye(&world);
        let centre = Point2::from(eye.translation.vector);
        let hits = camera.cast(&eye, &world);
        for (ray, hit) in camera.rays().iter().zip(hits) {
            let level = eye.rotation * ray.direction.xy();
            let agrees = [0.0, -2e-5, 2e-5].into_iter().any(|turn| {
                let level = UnitComplex::new(turn) * level;
                let direction = Vector3::new(level.x, level.y, ray.direction.z);
                [0.0, -1e-5, 1e-5].into_iter().any(|slack| {
                    let expected = distance_by_parry(&solids, &centre, height, &direction, slack);
                    hit.distance == expected
                        || (hit.distance - expected).abs() < 2e-4 * (1.0 + expected)
                })
            });
            prop_assert!(agrees, "{ray:?} hits at {} m in {world:?}", hit.distance);
        }
    }
}

/// Returns the 64-bit FNV-1a checksum.
fn checksum<'bytes>(bytes: impl Iterator<Item = &'bytes u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, &byte| {
        (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Checks that the images of a seeded run are byte-identical on every machine and in every version.
#[test]
fn images_of_a_seeded_run_match_the_golden_checksums() {
    let camera = camera();
    let sums = Scenario::ALL.map(|scenario| {
        let mut world = World::new(WorldSettings::default(), scenario, 1).unwrap();
        let mut frames = vec![camera.render(&world)];
        for step in 0..200 {
            if world.is_over() {
                world.reset(NonZeroU64::new(step + 2), None).unwrap();
            } else {
                world.step(Action::ALL[(step * step % 7) as usize]).unwrap();
            }
            frames.push(camera.render(&world));
        }
        checksum(frames.iter().flat_map(Frame::bytes))
    });
    assert_eq!(
        sums,
        [
            12709555447390270068,
            14309896719293980416,
            7774227787332069567,
            1463913559243764314,
            1940667215182447279,
            16726778999951231903,
            15985549511216541899,
            13300678955668798302
        ]
    );
}
