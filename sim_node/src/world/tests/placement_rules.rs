//! Where everything is after a reset.

use super::*;

#[test]
fn hold_after_every_reset() {
    for scenario in Scenario::ALL {
        let mut world = world(scenario, 1);
        for episode in 0..4_000 {
            world.reset(seed(episode), None).unwrap();
            assert_robot_touches_nothing(&world);
            if scenario.moving() {
                assert_cylinders_keep(&world, 0.75, 0.5, 0.0);
            } else {
                assert_cylinders_keep(&world, 0.7, 0.7, 0.5);
            }
            assert_eq!((world.steps(), world.is_over()), (0, false));
        }
    }
}

/// Walls, offsets and poses fall into equal parts equally often: 8,000 draws in each of
/// four parts differ from 2,000 by more than 200 (5 sigma) once in a million times.
#[test]
fn leave_everything_uniform() {
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
fn let_the_robot_start_inside_the_concave_wall() {
    let mut world = world(Scenario::Concave, 1);
    let inside = (0..1_000).filter(|_| {
        world.reset(None, None).unwrap();
        let from_arc = world.robot().translation.vector - Vector2::new(0.0, -0.35);
        from_arc.y > 0.0 && from_arc.norm() < 0.6
    });
    assert!(inside.count() > 20);
}

#[test]
fn hold_what_is_fixed() {
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
fn hold_what_is_fixed_later_from_the_next_reset_on() {
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

/// An unseeded reset leaves moving cylinders where they are, but not if they were given places.
#[test]
fn move_cylinders_to_places_that_are_new() {
    let centres = |world: &World| world.cylinders().iter().map(Cylinder::centre).collect();
    let mut world = world(Scenario::TwoMoving, 1);
    let fixed = Layout::from_lists(&[], &[0.5, 0.5, -0.5, 0.5], &[]).unwrap();
    world.set_layout(fixed.clone());
    world.reset(None, None).unwrap();
    let places = vec![Point2::new(0.5, 0.5), Point2::new(-0.5, 0.5)];
    assert_eq!(centres(&world), places);
    for _ in 0..5 {
        world.step(action(AHEAD)).unwrap();
    }
    // The same places again are nothing new.
    world.set_layout(fixed);
    let wandered: Vec<Point2<f64>> = centres(&world);
    assert_ne!(wandered, places);
    world.reset(None, None).unwrap();
    assert_eq!(centres(&world), wandered);
}

#[test]
fn place_a_random_exit_where_a_fixed_robot_does_not_touch_it() {
    let mut world = fixed_world(Scenario::Empty, &[], &[], &[1.1, 0.0, 0.0]).unwrap();
    for episode in 0..1_000 {
        world.reset(seed(episode), None).unwrap();
        assert_robot_touches_nothing(&world);
    }
}

#[test]
fn are_told_to_those_who_break_them() {
    use Scenario::*;
    for (scenario, exit, cylinders, robot, message) in [
        (
            ThreeCylinders,
            &[][..],
            &[0.0, 0.0][..],
            &[][..],
            "scenario `three_cylinders` has 3 cylinders, but 1 are held fixed",
        ),
        (
            OneCylinder,
            &[],
            &[0.72, 0.0],
            &[],
            "the cylinder at (0.72, 0) m is outside the central square: x and y are within \
             ±0.7 m",
        ),
        (
            TwoMoving,
            &[],
            &[0.0, 0.1, 0.0, -0.3],
            &[],
            "the cylinders at (0, 0.1) m and (0, -0.3) m are 0.4000 m apart: at least 0.5 m \
             is needed",
        ),
        (
            OneCylinder,
            &[],
            &[0.25, 0.0],
            &[0.0, 0.0, 0.0],
            "the robot at (0, 0) m is 0.2500 m from the cylinder at (0.25, 0) m: at least 0.5 \
             m is needed",
        ),
        (
            OneMoving,
            &[],
            &[0.2, 0.0],
            &[0.0, 0.0, 0.0],
            "the robot at (0, 0) m with yaw 0 touches a cylinder: it starts touching nothing",
        ),
        (
            Empty,
            &[],
            &[],
            &[0.0, 1.2, 0.0],
            "the robot at (0, 1.2) m with yaw 0 touches a wall: it starts touching nothing",
        ),
        (
            Empty,
            &[3.0, 0.5],
            &[],
            &[0.5, -1.1, 0.0],
            "the robot at (0.5, -1.1) m with yaw 0 touches the exit: it starts touching \
             nothing",
        ),
        (
            Concave,
            &[],
            &[],
            &[0.0, 0.3, 0.0],
            "the robot at (0, 0.3) m with yaw 0 touches the concave wall: it starts touching \
             nothing",
        ),
    ] {
        let error = fixed_world(scenario, exit, cylinders, robot).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
}

/// Three cylinders 0.5 m from the middle of their square and 0.7 m from each other only fit
/// near its corners.
#[test]
fn are_kept_where_room_is_scarce() {
    let world = fixed_world(Scenario::ThreeCylinders, &[], &[], &[0.0, 0.0, 0.0]).unwrap();
    assert_cylinders_keep(&world, 0.7, 0.7, 0.5);
}
