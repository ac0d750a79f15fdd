//! The fewest steps that lead out.

use super::*;

#[test]
fn counts_a_straight_way_by_hand() {
    // The exit's face is 1.15 m from the robot's centre, its side 1.075 m: 7.05 steps.
    let mut world = fixed_world(Scenario::Empty, &[0.0, 0.0], &[], &[0.0, 0.0, 0.0]).unwrap();
    assert_eq!(fewest_steps(&world), Some(8));
    world.step(action(AHEAD)).unwrap();
    assert_eq!(fewest_steps(&world), Some(7));
}

/// Means of 100,000 layouts; that of 1,000 has a standard error of 0.13.
#[test]
fn paths_lead_out_and_have_the_usual_length() {
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
            assert_eq!(fewest_steps(&world).map(|steps| steps as usize), Some(path.len()));
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

/// No path is shorter than what a search without a lower bound and without merging finds.
#[test]
fn no_path_is_shorter() {
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
            let fewest = fewest_steps(&world).unwrap() as usize;
            if fewest <= 5 {
                assert!(!can_escape_in(&world, fewest - 1), "{world:?}");
                compared += 1;
            }
        }
    }
}

#[test]
fn knows_nothing_where_obstacles_move() {
    assert_eq!(fewest_steps(&world(Scenario::OneMoving, 1)), None);
}
