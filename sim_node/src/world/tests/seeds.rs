//! Tests that a seed makes episodes reproducible.

use super::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_seed_determines_the_whole_episode(
        episode_seed in 1..u64::MAX,
        scenario in any_scenario(),
        other in any_scenario(),
        own_seed in any::<u64>(),
    ) {
        let mut one = world(scenario, own_seed);
        let mut two = world(other, own_seed.wrapping_add(1));
        play(&mut two);
        one.reset(seed(episode_seed), None).unwrap();
        two.reset(seed(episode_seed), Some(scenario)).unwrap();
        prop_assert_eq!(state(&one), state(&two));
        prop_assert_eq!(play(&mut one), play(&mut two));
    }

    #[test]
    fn a_seeded_reset_keeps_the_worlds_own_random_state(
        episode_seed in 1..u64::MAX,
        scenario in any_scenario(),
    ) {
        let mut one = world(scenario, 7);
        let mut two = one.clone();
        two.reset(seed(episode_seed), None).unwrap();
        play(&mut two);
        // Switches to another scenario and back, so that neither world keeps its moving cylinders.
        for world in [&mut one, &mut two] {
            world.reset(None, Some(Scenario::Empty)).unwrap();
            world.reset(None, Some(scenario)).unwrap();
        }
        prop_assert_eq!(state(&one), state(&two));
        prop_assert_eq!(play(&mut one), play(&mut two));
    }
}

#[test]
fn a_new_world_and_a_reset_with_the_same_seed_have_the_same_layout() {
    for scenario in Scenario::ALL {
        let mut other = world(Scenario::Empty, 1);
        other.reset(seed(9), Some(scenario)).unwrap();
        assert_eq!(state(&world(scenario, 9)), state(&other));
    }
}

#[test]
fn a_failed_reset_changes_nothing() {
    let mut world = fixed_world(Scenario::OneMoving, &[], &[0.0, 0.0], &[1.0, 0.0, 0.0]).unwrap();
    let mut other = world.clone();
    world.step(action(AHEAD)).unwrap();
    other.step(action(AHEAD)).unwrap();
    for episode in [None, seed(3)] {
        let error = other.reset(episode, Some(Scenario::TwoMoving)).unwrap_err();
        assert!(matches!(error, PlacementError::CylinderCount { expected: 2, given: 1, .. }));
    }
    assert_eq!((other.scenario(), other.steps()), (Scenario::OneMoving, 1));
    assert_eq!(state(&world), state(&other));
    assert_eq!(play(&mut world), play(&mut other));
}

/// Checks that a seeded run is the same on every machine and in every version: the number of steps,
/// the robot's final position, and the sum of the cylinders' coordinates.
#[test]
fn seeded_runs_match_the_golden_values() {
    let runs = Scenario::ALL.map(|scenario| {
        let mut world = world(scenario, 1);
        world.reset(seed(2), None).unwrap();
        let (steps, (robot, _, cylinders)) = play(&mut world);
        let centres = cylinders.iter().map(|cylinder| cylinder.centre());
        let sum = centres.fold(0.0, |sum, centre| sum + centre.x + centre.y);
        (steps, robot.translation.x, robot.translation.y, sum)
    });
    let expected = [
        (715, -0.45863620866970634, -1.1134581849341685, 0.0),
        (1503, -0.4162423536866528, -1.278177881803982, -0.056545827733114895),
        (676, -0.4101178048232081, -1.1763683675760408, 0.27335610739670163),
        (1722, -0.7917194505421614, -1.1552648119478046, -0.1841946344286145),
        (98, -0.9905079531358885, -1.096854055828751, 0.0),
        (994, -1.0132255438829703, -1.1088179157424065, 0.12673996891995976),
        (298, -0.8547810950275792, -1.057632546482044, 0.224637116034681),
        (98, -0.9365616609493785, -1.0976972246650063, -0.22246050526385208),
    ];
    assert_eq!(runs, expected);
}
