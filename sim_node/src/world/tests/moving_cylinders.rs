//! Tests of the motion of cylinders, and of resets with moving cylinders.

use super::*;

proptest! {
    #[test]
    fn moving_cylinders_follow_the_rules_at_every_step(
        seed in any::<u64>(),
        scenario in moving_scenario(),
        actions in proptest::collection::vec(0..7_u8, 2_000),
    ) {
        let mut world = world(scenario, seed);
        for index in actions {
            if world.is_over() {
                world.reset(None, None).unwrap();
            }
            let before: Vec<_> = world.cylinders().iter().map(Cylinder::centre).collect();
            world.step(action(index)).unwrap();
            assert_cylinder_spacing(&world, 0.75, 0.5, 0.0);
            let footprint = Footprint::at(world.robot());
            for (cylinder, before) in world.cylinders().iter().zip(before) {
                let moved = distance(&cylinder.centre(), &before);
                prop_assert!(moved == 0.0 || (moved - CYLINDER_STEP_LENGTH).abs() < 1e-12);
                prop_assert!(!cylinder.touches(&footprint));
            }
        }
    }
}

#[test]
fn cylinders_move_along_their_heading_in_most_steps() {
    let mut world = world(Scenario::ThreeMoving, 3);
    let (mut moved, mut stayed) = (0, 0);
    for _ in 0..2_000 {
        if world.is_over() {
            world.reset(None, None).unwrap();
        }
        let before = world.cylinders().to_vec();
        world.step(action(1)).unwrap();
        for (after, before) in world.cylinders().iter().zip(before) {
            let displacement = after.centre() - before.centre();
            if displacement.norm() == 0.0 {
                stayed += 1;
            } else {
                moved += 1;
                let ahead = after.pose().rotation * Vector2::new(CYLINDER_STEP_LENGTH, 0.0);
                assert!((displacement - ahead).norm() < 1e-12);
            }
        }
    }
    assert!(moved > 4 * stayed && stayed > 0, "{moved} moved, {stayed} stayed");
}

#[test]
fn cylinders_keep_their_heading_if_its_deviation_is_zero() {
    let settings = WorldSettings { heading_deviation: 0.0, ..WorldSettings::default() };
    let mut world = World::new(settings, Scenario::OneMoving, 1).unwrap();
    let before = world.cylinders()[0].pose;
    world.step(action(AHEAD)).unwrap();
    assert_eq!(world.cylinders()[0].pose.rotation, before.rotation);
}

#[test]
fn an_unseeded_reset_keeps_the_moving_cylinders() {
    let mut world = world(Scenario::ThreeMoving, 1);
    play(&mut world);
    let before = world.cylinders().to_vec();
    world.reset(None, None).unwrap();
    assert_eq!(world.cylinders(), before);
    assert_robot_touches_nothing(&world);
    world.reset(seed(4), None).unwrap();
    assert_ne!(world.cylinders(), before);
}

#[test]
fn a_new_scenario_places_the_cylinders_again() {
    let mut world = world(Scenario::ThreeCylinders, 1);
    let before = world.cylinders().to_vec();
    world.reset(None, Some(Scenario::ThreeMoving)).unwrap();
    assert!(world.cylinders().iter().all(|cylinder| !before.contains(cylinder)));
    world.reset(None, Some(Scenario::OneMoving)).unwrap();
    assert_eq!(world.cylinders().len(), 1);
}

/// Checks that an unseeded reset succeeds even if a cylinder has moved to the robot's fixed start
/// pose.
#[test]
fn an_unseeded_reset_replaces_cylinders_in_the_way_of_a_fixed_robot() {
    let robot = [0.0, 0.0, 0.0];
    let mut world = fixed_world(Scenario::OneMoving, &[0.0, 0.0], &[], &robot).unwrap();
    let mut replaced = 0;
    for _ in 0..200 {
        play(&mut world);
        let before = world.cylinders().to_vec();
        world.reset(None, None).unwrap();
        assert_robot_touches_nothing(&world);
        replaced += u32::from(world.cylinders() != before);
    }
    assert!((1..200).contains(&replaced), "replaced in {replaced} of 200 resets");
}
