//! Tests of the placement rules at a reset.

use super::*;

#[test]
fn every_reset_follows_the_placement_rules() {
    for scenario in Scenario::ALL {
        let mut world = world(scenario, 1);
        for episode in 0..4_000 {
            world.reset(seed(episode), None).unwrap();
            assert_robot_touches_nothing(&world);
            if scenario.has_moving_obstacles() {
                assert_cylinder_spacing(&world, 0.75, 0.5, 0.0);
            } else {
                assert_cylinder_spacing(&world, 0.7, 0.7, 0.5);
            }
            assert_eq!((world.steps(), world.is_over()), (0, false));
        }
    }
}

/// Sorts 8,000 draws of the wall, offset, position and heading into four equal bins each. The
/// probability that a count differs from 2,000 by more than 200 (5 sigma) is below one in a
/// million.
#[test]
fn random_layouts_are_uniform() {
    let mut world = world(Scenario::Empty, 5);
    let mut counts = [[0; 4]; 4];
    for _ in 0..8_000 {
        world.reset(None, None).unwrap();
        let exit = world.exit();
        let wall = Wall::ALL.iter().position(|&wall| wall == exit.wall()).unwrap();
        let offset = ((exit.offset() + EXIT_REACH) / EXIT_REACH * 2.0) as usize;
        let robot = world.robot();
        let quadrant =
            usize::from(robot.translation.x > 0.0) + 2 * usize::from(robot.translation.y > 0.0);
        let heading =
            usize::from(robot.rotation.re > 0.0) + 2 * usize::from(robot.rotation.im > 0.0);
        for (part, count) in [wall, offset, quadrant, heading].into_iter().zip(&mut counts) {
            count[part] += 1;
        }
    }
    for count in counts.as_flattened() {
        assert!((1_800..=2_200).contains(count), "{counts:?}");
    }
}

#[test]
fn the_robot_can_start_inside_the_concave_wall() {
    let mut world = world(Scenario::Concave, 1);
    let inside = (0..1_000).filter(|_| {
        world.reset(None, None).unwrap();
        let from_arc = world.robot().translation.vector - Vector2::new(0.0, -0.35);
        from_arc.y > 0.0 && from_arc.norm() < 0.6
    });
    assert!(inside.count() > 20);
}

#[test]
fn resets_keep_the_fixed_layout() {
    let cylinders = [0.35, 0.35, -0.35, 0.35];
    let robot = [0.2, -0.9, 1.0];
    let mut world = fixed_world(Scenario::TwoCylinders, &[1.0, 0.25], &cylinders, &robot).unwrap();
    for episode in 0..10 {
        world.reset(seed(episode), None).unwrap();
        assert_eq!(*world.exit(), Exit::new(Wall::PositiveY, 0.25).unwrap());
        assert_eq!(world.cylinders()[1].centre(), Point2::new(-0.35, 0.35));
        assert_eq!(*world.robot(), Isometry2::new(Vector2::new(0.2, -0.9), 1.0));
    }
}

#[test]
fn a_new_fixed_layout_takes_effect_at_the_next_reset() {
    let mut world = world(Scenario::Empty, 1);
    let before = state(&world);
    let fixed = Layout::from_lists(&[2.0, -0.5], &[], &[0.5, 0.5, 2.0]).unwrap();
    world.set_layout(fixed);
    assert_eq!(state(&world), before);
    world.reset(None, None).unwrap();
    assert_eq!(*world.exit(), Exit::new(Wall::NegativeX, -0.5).unwrap());
    assert_eq!(*world.robot(), Isometry2::new(Vector2::new(0.5, 0.5), 2.0));

    let impossible = Layout::from_lists(&[], &[], &[0.0, 1.2, 0.0]).unwrap();
    world.set_layout(impossible);
    let before = state(&world);
    let error = world.reset(None, None).unwrap_err();
    assert!(matches!(error, PlacementError::RobotTouches { .. }), "{error}");
    assert_eq!(state(&world), before);

    world.set_layout(Layout::default());
    world.reset(None, None).unwrap();
    assert_ne!(*world.robot(), before.0);
}

/// An unseeded reset keeps the moving cylinders unless the layout has new fixed cylinders.
#[test]
fn an_unseeded_reset_places_cylinders_at_new_fixed_positions() {
    let centres = |world: &World| world.cylinders().iter().map(Cylinder::centre).collect();
    let mut world = world(Scenario::TwoMoving, 1);
    let fixed = Layout::from_lists(&[], &[0.5, 0.5, -0.5, 0.5], &[]).unwrap();
    world.set_layout(fixed.clone());
    world.reset(None, None).unwrap();
    let positions = vec![Point2::new(0.5, 0.5), Point2::new(-0.5, 0.5)];
    assert_eq!(centres(&world), positions);
    for _ in 0..5 {
        world.step(action(AHEAD)).unwrap();
    }
    // Setting the same positions again is not a change.
    world.set_layout(fixed);
    let moved: Vec<Point2<f64>> = centres(&world);
    assert_ne!(moved, positions);
    world.reset(None, None).unwrap();
    assert_eq!(centres(&world), moved);
}

#[test]
fn a_random_exit_never_touches_a_fixed_robot() {
    let mut world = fixed_world(Scenario::Empty, &[], &[], &[1.1, 0.0, 0.0]).unwrap();
    for episode in 0..1_000 {
        world.reset(seed(episode), None).unwrap();
        assert_robot_touches_nothing(&world);
    }
}

#[test]
fn rejects_fixed_layouts_that_violate_a_rule() {
    use Scenario::*;
    for (scenario, exit, cylinders, robot, message) in [
        (
            ThreeCylinders,
            &[][..],
            &[0.0, 0.0][..],
            &[][..],
            "fixed cylinders: found 1 (expected: 3 in scenario three_cylinders)",
        ),
        (
            OneCylinder,
            &[],
            &[0.72, 0.0],
            &[],
            "cylinder at (0.72, 0) m: outside the central square (expected: x and y within \
             ±0.7 m)",
        ),
        (
            TwoMoving,
            &[],
            &[0.0, 0.1, 0.0, -0.3],
            &[],
            "cylinders at (0, 0.1) m and (0, -0.3) m: distance 0.4000 m (expected: at least \
             0.5 m)",
        ),
        (
            OneCylinder,
            &[],
            &[0.25, 0.0],
            &[0.0, 0.0, 0.0],
            "robot at (0, 0) m and cylinder at (0.25, 0) m: distance 0.2500 m (expected: at \
             least 0.5 m)",
        ),
        (
            OneMoving,
            &[],
            &[0.2, 0.0],
            &[0.0, 0.0, 0.0],
            "robot at (0, 0) m with yaw 0 rad: touches a cylinder (expected: a collision-free \
             start pose)",
        ),
        (
            Empty,
            &[],
            &[],
            &[0.0, 1.2, 0.0],
            "robot at (0, 1.2) m with yaw 0 rad: touches a wall (expected: a collision-free \
             start pose)",
        ),
        (
            Empty,
            &[3.0, 0.5],
            &[],
            &[0.5, -1.1, 0.0],
            "robot at (0.5, -1.1) m with yaw 0 rad: touches the exit (expected: a \
             collision-free start pose)",
        ),
        (
            Concave,
            &[],
            &[],
            &[0.0, 0.3, 0.0],
            "robot at (0, 0.3) m with yaw 0 rad: touches the concave wall (expected: a \
             collision-free start pose)",
        ),
    ] {
        let error = fixed_world(scenario, exit, cylinders, robot).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
}

/// Three cylinders at least 0.5 m from the centre of the room and 0.7 m from each other fit only
/// near the corners of the central square.
#[test]
fn finds_a_placement_when_space_is_scarce() {
    let world = fixed_world(Scenario::ThreeCylinders, &[], &[], &[0.0, 0.0, 0.0]).unwrap();
    assert_cylinder_spacing(&world, 0.7, 0.7, 0.5);
}
