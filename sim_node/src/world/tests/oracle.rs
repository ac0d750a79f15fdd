//! Tests of the full-knowledge shortest paths.

use super::*;

#[test]
fn a_straight_path_has_the_length_calculated_by_hand() {
    // The face of the exit is 1.15 m from the robot's centre and 1.075 m from its front: 7.05
    // steps.
    let mut world = fixed_world(Scenario::Empty, &[0.0, 0.0], &[], &[0.0, 0.0, 0.0]).unwrap();
    assert_eq!(shortest_path_length(&world), Some(8));
    world.step(action(AHEAD)).unwrap();
    assert_eq!(shortest_path_length(&world), Some(7));
}

/// The expected means are over 100,000 layouts. The mean over 1,000 layouts has a standard error of
/// 0.13.
#[test]
fn shortest_paths_reach_the_exit_and_have_the_expected_mean_length() {
    for (scenario, mean) in [
        (Scenario::Empty, 9.36),
        (Scenario::OneCylinder, 9.48),
        (Scenario::ThreeCylinders, 9.79),
        (Scenario::Concave, 10.18),
    ] {
        let mut world = world(scenario, 1);
        let mut total = 0;
        for _ in 0..1_000 {
            world.reset(None, None).unwrap();
            let path = shortest_path(&world).unwrap();
            assert_eq!(shortest_path_length(&world).map(|steps| steps as usize), Some(path.len()));
            let (last, before) = path.split_last().unwrap();
            for &action in before {
                let outcome = world.step(action).unwrap();
                assert!(!outcome.terminated && !outcome.blocked);
            }
            assert!(world.step(*last).unwrap().terminated);
            total += path.len();
        }
        let actual = total as f64 / 1_000.0;
        assert!((actual - mean).abs() < 0.4, "{scenario}: {actual} steps");
    }
}

/// Checks the length of the shortest path against an exhaustive search, which uses no lower bound
/// and does not merge poses.
#[test]
fn an_exhaustive_search_finds_no_shorter_path() {
    fn can_escape_in(world: &World, steps: usize) -> bool {
        steps > 0
            && Action::ALL.into_iter().any(|action| {
                let mut next = world.clone();
                let outcome = next.step(action).unwrap();
                outcome.terminated || !outcome.blocked && can_escape_in(&next, steps - 1)
            })
    }
    for scenario in [Scenario::Empty, Scenario::ThreeCylinders] {
        let mut world = world(scenario, 2);
        let mut compared = 0;
        while compared < 20 {
            world.reset(None, None).unwrap();
            let length = shortest_path_length(&world).unwrap() as usize;
            if length <= 5 {
                assert!(!can_escape_in(&world, length - 1), "{world:?}");
                compared += 1;
            }
        }
    }
}

#[test]
fn moving_cylinders_have_no_shortest_path() {
    assert_eq!(shortest_path_length(&world(Scenario::OneMoving, 1)), None);
}
