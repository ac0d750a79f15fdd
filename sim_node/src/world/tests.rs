//! The rules of the world, over many episodes.

use std::f64::consts::FRAC_PI_4;
use std::num::NonZeroU64;

use nalgebra::{Isometry2, Point2, Vector2, distance};
use proptest::prelude::*;

use super::*;

fn world(scenario: Scenario, seed: u64) -> World {
    World::new(WorldSettings::default(), scenario, seed).unwrap()
}

/// A world in which these parts are fixed, as the parameters have them.
fn fixed_world(
    scenario: Scenario,
    exit: &[f64],
    cylinders: &[f64],
    robot: &[f64],
) -> Result<World, PlacementError> {
    let layout = Layout::from_parameters(exit, cylinders, robot).unwrap();
    World::new(WorldSettings { layout, ..WorldSettings::default() }, scenario, 0)
}

fn seed(seed: u64) -> Option<NonZeroU64> {
    NonZeroU64::new(seed)
}

fn action(index: u8) -> Action {
    Action::try_from(index).unwrap()
}

const AHEAD: u8 = 3;

/// What can be seen of a world.
fn state(world: &World) -> (Isometry2<f64>, Exit, Vec<Cylinder>) {
    (*world.robot(), *world.exit(), world.cylinders().to_vec())
}

/// The number of steps at which `world` ends under a fixed pattern of actions, and its last state.
fn play(world: &mut World) -> (u32, (Isometry2<f64>, Exit, Vec<Cylinder>)) {
    let mut turn = 0_u32;
    while !world.is_over() {
        world.step(action((turn.wrapping_mul(2_654_435_761) >> 16) as u8 % 7)).unwrap();
        turn += 1;
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

fn assert_cylinders_keep(world: &World, half_square: f64, apart: f64, from_robot: f64) {
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

mod placement_rules {
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
        let mut world =
            fixed_world(Scenario::TwoCylinders, &[1.0, 0.25], &cylinders, &robot).unwrap();
        for episode in 0..10 {
            world.reset(seed(episode), None).unwrap();
            assert_eq!(*world.exit(), Exit::new(Wall::PositiveY, 0.25).unwrap());
            assert_eq!(world.cylinders()[1].centre(), Point2::new(-0.35, 0.35));
            assert_eq!(*world.robot(), Isometry2::new(Vector2::new(0.2, -0.9), 1.0));
        }
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
                "scenario `three_cylinders` has 3 cylinders, but fixed_cylinders places 1",
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
}

mod steps {
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
        let layout = Layout::from_parameters(&[2.0, 0.0], &[], &[1.1, 0.5, 0.0]).unwrap();
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
        let layout = Layout::from_parameters(&[0.0, 0.0], &[], &[1.04, 0.0, 0.0]).unwrap();
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
}

mod moving_cylinders {
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
}

mod seeds {
    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn decide_everything_in_an_episode(
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
        fn leave_the_worlds_own_randomness_alone(
            episode_seed in 1..u64::MAX,
            scenario in any_scenario(),
        ) {
            let mut one = world(scenario, 7);
            let mut two = one.clone();
            two.reset(seed(episode_seed), None).unwrap();
            play(&mut two);
            // Out of a moving scenario and back, so that neither keeps its cylinders.
            for world in [&mut one, &mut two] {
                world.reset(None, Some(Scenario::Empty)).unwrap();
                world.reset(None, Some(scenario)).unwrap();
            }
            prop_assert_eq!(state(&one), state(&two));
            prop_assert_eq!(play(&mut one), play(&mut two));
        }
    }

    #[test]
    fn of_a_world_and_of_a_reset_give_the_same_layout() {
        for scenario in Scenario::ALL {
            let mut other = world(Scenario::Empty, 1);
            other.reset(seed(9), Some(scenario)).unwrap();
            assert_eq!(state(&world(scenario, 9)), state(&other));
        }
    }

    #[test]
    fn are_untouched_by_a_reset_that_fails() {
        let mut world =
            fixed_world(Scenario::OneMoving, &[], &[0.0, 0.0], &[1.0, 0.0, 0.0]).unwrap();
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

    /// A run in every scenario is the same everywhere and for ever: the steps until the robot
    /// escapes, where it then is, and the sum of where the cylinders are.
    #[test]
    fn give_the_runs_they_always_gave() {
        let runs = Scenario::ALL.map(|scenario| {
            let mut world = world(scenario, 1);
            world.reset(seed(2), None).unwrap();
            let (steps, (robot, _, cylinders)) = play(&mut world);
            let places = cylinders.iter().map(|cylinder| cylinder.centre());
            let sum = places.fold(0.0, |sum, centre| sum + centre.x + centre.y);
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
}

mod oracle {
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
}
