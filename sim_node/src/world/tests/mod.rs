//! Tests of the world's rules over many episodes.

mod moving_cylinders;
mod oracle;
mod placement_rules;
mod seeds;
mod steps;

use std::f64::consts::FRAC_PI_4;
use std::num::NonZeroU64;

use nalgebra::{Isometry2, Point2, Vector2, distance};
use proptest::prelude::*;

use super::*;

fn world(scenario: Scenario, seed: u64) -> World {
    World::new(WorldSettings::default(), scenario, seed).unwrap()
}

/// Returns a world with a fixed layout, in the format of the parameters `fixed_*`.
fn fixed_world(
    scenario: Scenario,
    exit: &[f64],
    cylinders: &[f64],
    robot: &[f64],
) -> Result<World, PlacementError> {
    let layout = Layout::from_lists(exit, cylinders, robot).unwrap();
    World::new(WorldSettings { layout, ..WorldSettings::default() }, scenario, 0)
}

fn seed(seed: u64) -> Option<NonZeroU64> {
    NonZeroU64::new(seed)
}

fn action(index: u8) -> Action {
    Action::try_from(index).unwrap()
}

/// Index of the action without a turn.
const AHEAD: u8 = 3;

/// Returns the robot's pose, the exit and the cylinders.
fn state(world: &World) -> (Isometry2<f64>, Exit, Vec<Cylinder>) {
    (*world.robot(), *world.exit(), world.cylinders().to_vec())
}

/// Plays the episode to its end with a fixed sequence of actions. Returns the number of steps and
/// the last state.
fn play(world: &mut World) -> (u32, (Isometry2<f64>, Exit, Vec<Cylinder>)) {
    let mut count = 0_u32;
    while !world.is_over() {
        world.step(action((count.wrapping_mul(2_654_435_761) >> 16) as u8 % 7)).unwrap();
        count += 1;
    }
    (world.steps(), state(world))
}

fn any_scenario() -> impl Strategy<Value = Scenario> {
    proptest::sample::select(Scenario::ALL.to_vec())
}

fn moving_scenario() -> impl Strategy<Value = Scenario> {
    proptest::sample::select(vec![Scenario::OneMoving, Scenario::TwoMoving, Scenario::ThreeMoving])
}

fn assert_robot_touches_nothing(world: &World) {
    let footprint = Footprint::at(world.robot());
    assert!(!world.obstacles().touch(&footprint), "{world:?}");
    assert!(!world.exit().touches(&footprint), "{world:?}");
}

fn assert_cylinder_spacing(world: &World, half_square: f64, apart: f64, from_robot: f64) {
    let centres: Vec<Point2<f64>> = world.cylinders().iter().map(Cylinder::centre).collect();
    assert_eq!(centres.len(), world.scenario().cylinders());
    let robot = Point2::from(world.robot().translation.vector);
    for (index, centre) in centres.iter().enumerate() {
        assert!(centre.x.abs() <= half_square && centre.y.abs() <= half_square, "{centre}");
        assert!(distance(centre, &robot) >= from_robot, "{centre} {robot}");
        for other in &centres[..index] {
            assert!(distance(centre, other) >= apart, "{centre} {other}");
        }
    }
}
