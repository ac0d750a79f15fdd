//! Tests of robot steps.

use task::action::STEP_LENGTH;

use super::*;

#[test]
fn the_action_ahead_moves_the_robot_half_a_foot() {
    let mut world = fixed_world(Scenario::Empty, &[2.0, 0.0], &[], &[0.0, 0.5, 0.0]).unwrap();
    let outcome = world.step(action(AHEAD)).unwrap();
    let free = Outcome { reward: -0.1, terminated: false, truncated: false, blocked: false };
    assert_eq!(outcome, free);
    assert_eq!(*world.robot(), Isometry2::new(Vector2::new(STEP_LENGTH, 0.5), 0.0));
}

#[test]
fn a_step_into_a_wall_is_blocked_and_keeps_position_and_heading() {
    let robot = [1.1, 0.5, 0.0];
    let mut world = fixed_world(Scenario::Empty, &[2.0, 0.0], &[], &robot).unwrap();
    let before = *world.robot();
    for index in [1, 2, 3] {
        let expected = index == 2 || index == AHEAD;
        let mut world = world.clone();
        assert_eq!(world.step(action(index)).unwrap().blocked, expected, "action {index}");
        assert_eq!(*world.robot() == before, expected);
    }
    let outcome = world.step(action(AHEAD)).unwrap();
    let blocked = Outcome { reward: -0.1, terminated: false, truncated: false, blocked: true };
    assert_eq!(outcome, blocked);
    assert_eq!(world.steps(), 1);
}

/// At its new pose, the robot touches both the exit and the wall behind it.
#[test]
fn the_exit_takes_precedence_over_the_wall_behind_it() {
    let mut world = fixed_world(Scenario::Empty, &[0.0, 0.0], &[], &[1.04, 0.0, 0.0]).unwrap();
    let outcome = world.step(action(AHEAD)).unwrap();
    let escape = Outcome { reward: 0.0, terminated: true, truncated: false, blocked: false };
    assert_eq!(outcome, escape);
    assert_eq!(world.robot().translation.x, 1.04 + STEP_LENGTH);
    assert!(world.obstacles().touch(&Footprint::at(world.robot())));
    assert_eq!(shortest_path_length(&world), Some(0));
    assert_eq!(world.step(action(AHEAD)), Err(EpisodeOver { steps: 1 }));
    assert_eq!(
        EpisodeOver { steps: 1 }.to_string(),
        "the episode ended at step 1; reset to start the next one"
    );
}

/// The robot is 5 mm from a wall, which it touches during the turn, but not at the new pose.
#[test]
fn contact_is_tested_only_at_the_new_pose() {
    let mut world = fixed_world(Scenario::Empty, &[2.0, 0.0], &[], &[0.0, 1.17, 0.0]).unwrap();
    let turned = Isometry2::new(Vector2::new(0.0, 1.17), -FRAC_PI_4);
    assert!(world.obstacles().touch(&Footprint::at(&turned)));
    assert!(!world.step(action(1)).unwrap().blocked);
}

#[test]
fn an_episode_is_truncated_at_the_step_limit() {
    let layout = Layout::from_lists(&[2.0, 0.0], &[], &[1.1, 0.5, 0.0]).unwrap();
    let settings = WorldSettings { max_steps: 3, layout, ..WorldSettings::default() };
    let mut world = World::new(settings, Scenario::Empty, 0).unwrap();
    let truncated: Vec<bool> =
        (0..3).map(|_| world.step(action(AHEAD)).unwrap().truncated).collect();
    assert_eq!(truncated, [false, false, true]);
    assert_eq!(world.step(action(AHEAD)), Err(EpisodeOver { steps: 3 }));
    world.reset(None, None).unwrap();
    assert!(world.step(action(AHEAD)).is_ok());
}

#[test]
fn an_escape_in_the_last_step_is_terminated_and_not_truncated() {
    let layout = Layout::from_lists(&[0.0, 0.0], &[], &[1.04, 0.0, 0.0]).unwrap();
    let settings = WorldSettings { max_steps: 1, layout, ..WorldSettings::default() };
    let mut world = World::new(settings, Scenario::Empty, 0).unwrap();
    let outcome = world.step(action(AHEAD)).unwrap();
    assert!(outcome.terminated && !outcome.truncated);
}

proptest! {
    #[test]
    fn the_robot_touches_nothing_after_a_step(
        seed in any::<u64>(),
        scenario in any_scenario(),
        actions in proptest::collection::vec(0..7_u8, 200),
    ) {
        let mut world = world(scenario, seed);
        for index in actions {
            let before = *world.robot();
            let outcome = world.step(action(index)).unwrap();
            if outcome.terminated {
                prop_assert_eq!(outcome.reward, 0.0);
                break;
            }
            prop_assert_eq!(outcome.reward, -0.1);
            assert_robot_touches_nothing(&world);
            if outcome.blocked {
                prop_assert_eq!(*world.robot(), before);
            } else {
                let moved = world.robot().translation.vector - before.translation.vector;
                prop_assert!((moved.norm() - STEP_LENGTH).abs() < 1e-12);
            }
        }
    }
}
