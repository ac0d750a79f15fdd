//! How cylinders move, and what a reset does to them.

use super::*;

proptest! {
    #[test]
    fn keep_their_rules_at_every_step(
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
            assert_cylinders_keep(&world, 0.75, 0.5, 0.0);
            let footprint = Footprint::at(world.robot());
            for (cylinder, before) in world.cylinders().iter().zip(before) {
                let way = distance(&cylinder.centre(), &before);
                prop_assert!(way == 0.0 || (way - CYLINDER_STEP_LENGTH).abs() < 1e-12);
                prop_assert!(!cylinder.touches(&footprint));
            }
        }
    }
}

#[test]
fn move_nearly_always_and_in_the_direction_they_face() {
    let mut world = world(Scenario::ThreeMoving, 3);
    let (mut moved, mut stayed) = (0, 0);
    for _ in 0..2_000 {
        if world.is_over() {
            world.reset(None, None).unwrap();
        }
        let before = world.cylinders().to_vec();
        world.step(action(1)).unwrap();
        for (after, before) in world.cylinders().iter().zip(before) {
            let way = after.centre() - before.centre();
            if way.norm() == 0.0 {
                stayed += 1;
            } else {
                moved += 1;
                let ahead = after.pose().rotation * Vector2::new(CYLINDER_STEP_LENGTH, 0.0);
                assert!((way - ahead).norm() < 1e-12);
            }
        }
    }
    assert!(moved > 4 * stayed && stayed > 0, "{moved} moved, {stayed} stayed");
}

#[test]
fn do_not_turn_without_deviation() {
    let settings = WorldSettings { heading_deviation: 0.0, ..WorldSettings::default() };
    let mut world = World::new(settings, Scenario::OneMoving, 1).unwrap();
    let before = world.cylinders()[0].pose;
    world.step(action(AHEAD)).unwrap();
    assert_eq!(world.cylinders()[0].pose.rotation, before.rotation);
}

#[test]
fn stay_where_they_are_at_an_unseeded_reset() {
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
fn are_placed_anew_when_the_scenario_changes() {
    let mut world = world(Scenario::ThreeCylinders, 1);
    let standing = world.cylinders().to_vec();
    world.reset(None, Some(Scenario::ThreeMoving)).unwrap();
    assert!(world.cylinders().iter().all(|cylinder| !standing.contains(cylinder)));
    world.reset(None, Some(Scenario::OneMoving)).unwrap();
    assert_eq!(world.cylinders().len(), 1);
}

/// Somebody who fixes the robot and resets without seeds must not be stopped by a cylinder
/// that has wandered to where the robot starts.
#[test]
fn give_way_to_a_fixed_robot() {
    let robot = [0.0, 0.0, 0.0];
    let mut world = fixed_world(Scenario::OneMoving, &[0.0, 0.0], &[], &robot).unwrap();
    let mut placed_anew = 0;
    for _ in 0..200 {
        play(&mut world);
        let before = world.cylinders().to_vec();
        world.reset(None, None).unwrap();
        assert_robot_touches_nothing(&world);
        placed_anew += u32::from(world.cylinders() != before);
    }
    assert!((1..200).contains(&placed_anew), "{placed_anew}");
}
