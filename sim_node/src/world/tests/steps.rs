//! What one step of the robot does.

use task::action::STEP_LENGTH;

use super::*;

#[test]
fn ahead_moves_the_robot_half_a_foot() {
    let mut world = fixed_world(Scenario::Empty, &[2.0, 0.0], &[], &[0.0, 0.5, 0.0]).unwrap();
    let outcome = world.step(action(AHEAD)).unwrap();
    let free = Outcome { reward: -0.1, terminated: false, truncated: false, blocked: false };
    assert_eq!(outcome, free);
    assert_eq!(*world.robot(), Isometry2::new(Vector2::new(STEP_LENGTH, 0.5), 0.0));
}

#[test]
fn into_a_wall_are_blocked_and_leave_pose_and_heading() {
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

/// At its new pose the robot touches the exit and the wall behind it.
#[test]
fn into_the_exit_escape_although_it_stands_in_the_wall() {
    let mut world = fixed_world(Scenario::Empty, &[0.0, 0.0], &[], &[1.04, 0.0, 0.0]).unwrap();
    let outcome = world.step(action(AHEAD)).unwrap();
    let escape = Outcome { reward: 0.0, terminated: true, truncated: false, blocked: false };
    assert_eq!(outcome, escape);
    assert_eq!(world.robot().translation.x, 1.04 + STEP_LENGTH);
    assert!(world.obstacles().touch(&Footprint::at(world.robot())));
    assert_eq!(fewest_steps(&world), Some(0));
    assert_eq!(world.step(action(AHEAD)), Err(EpisodeOver { steps: 1 }));
    assert_eq!(
        EpisodeOver { steps: 1 }.to_string(),
        "the episode ended with step 1: reset before the next step"
    );
}

/// 5 mm beside the wall there is no room to turn, but none is needed: after the step the robot
/// is clear of it.
#[test]
fn test_contact_at_the_new_pose_only() {
    let mut world = fixed_world(Scenario::Empty, &[2.0, 0.0], &[], &[0.0, 1.17, 0.0]).unwrap();
    let turned = Isometry2::new(Vector2::new(0.0, 1.17), -FRAC_PI_4);
    assert!(world.obstacles().touch(&Footprint::at(&turned)));
    assert!(!world.step(action(1)).unwrap().blocked);
}

#[test]
fn end_when_the_episode_has_had_them_all() {
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
fn that_escape_last_are_terminated_and_not_truncated() {
    let layout = Layout::from_lists(&[0.0, 0.0], &[], &[1.04, 0.0, 0.0]).unwrap();
    let settings = WorldSettings { max_steps: 1, layout, ..WorldSettings::default() };
    let mut world = World::new(settings, Scenario::Empty, 0).unwrap();
    let outcome = world.step(action(AHEAD)).unwrap();
    assert!(outcome.terminated && !outcome.truncated);
}

proptest! {
    #[test]
    fn leave_the_robot_clear_of_everything(
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
                let way = world.robot().translation.vector - before.translation.vector;
                prop_assert!((way.norm() - STEP_LENGTH).abs() < 1e-12);
            }
        }
    }
}
