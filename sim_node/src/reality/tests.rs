//! Tests of the perturbations, alone and in a simulation.

use std::num::NonZeroU64;

use nalgebra::{Isometry2, UnitComplex, Vector2};
use proptest::prelude::*;
use task::{Action, Scenario, action::STEP_LENGTH};

use super::*;
use crate::{
    Simulation,
    camera::{Camera, CameraSettings, Frame},
    world::{Layout, World, WorldSettings},
};

fn simulation(reality: Reality, scenario: Scenario, seed: u64) -> Simulation {
    let settings = WorldSettings { reality, ..WorldSettings::default() };
    let world = World::new(settings, scenario, seed).unwrap();
    let mut simulation = Simulation::new(world, Camera::new(CameraSettings::default()).unwrap());
    simulation.reset(NonZeroU64::new(seed), None).unwrap();
    simulation
}

/// Returns the image and the pose after each step of an episode, the start included.
fn episode(reality: Reality, scenario: Scenario, seed: u64) -> Vec<(Frame, [f64; 4])> {
    let mut simulation = simulation(reality, scenario, seed);
    let state = |simulation: &Simulation| {
        let pose = simulation.world().robot();
        let pose = [pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im];
        (simulation.frame(0), pose)
    };
    let mut states = vec![state(&simulation)];
    for index in 0..40 {
        if simulation.world().is_over() {
            break;
        }
        simulation.step(Action::ALL[(index * 5 + seed as usize) % Action::COUNT]).unwrap();
        states.push(state(&simulation));
    }
    states
}

/// Returns the mean and the standard deviation.
fn moments(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.into_iter().collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
    (mean, variance.sqrt())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn an_episode_depends_only_on_its_seed(seed in 1_u64..1 << 40, scenario in 0_usize..8) {
        let scenario = Scenario::ALL[scenario];
        for level in Randomization::ALL {
            let reality = Reality::of(level);
            prop_assert_eq!(episode(reality, scenario, seed), episode(reality, scenario, seed));
        }
    }

    #[test]
    fn perturbations_never_let_the_robot_touch_anything(seed in 1_u64..1 << 40, scenario in 0_usize..8) {
        let mut reality = Reality::of(Randomization::Strong);
        reality.motion.blocked = BlockedMotion::StopShort;
        let mut simulation = simulation(reality, Scenario::ALL[scenario], seed);
        for index in 0..60 {
            if simulation.world().is_over() {
                break;
            }
            simulation.step(Action::ALL[(index * 3 + seed as usize) % Action::COUNT]).unwrap();
            let free = simulation.world().is_over() || !simulation.world().robot_touches_obstacle();
            prop_assert!(free, "step {}", index + 1);
        }
    }

    #[test]
    fn drawn_values_are_within_their_intervals(key in any::<u64>()) {
        let reality = Reality::of(Randomization::Strong);
        let Conditions { camera, light, surfaces, motion, odometry, obstacles, .. } =
            Conditions::draw(&reality, key);
        let degrees = |angle: f64, limit: f64| angle.to_degrees().abs() <= limit + 1e-9;
        prop_assert!((0.6..=1.5).contains(&camera.gain));
        prop_assert!(camera.color.iter().all(|factor| (0.75..=1.3).contains(factor)));
        prop_assert!([camera.pitch, camera.roll, camera.yaw].iter().all(|a| degrees(*a, 3.0)));
        prop_assert!(camera.height.abs() <= 0.03 && camera.lens.abs() <= 0.05);
        prop_assert!(degrees(light.azimuth, 60.0) && degrees(light.elevation, 60.0));
        for tint in [surfaces.wall, surfaces.exit, surfaces.obstacle, surfaces.floor, surfaces.sky] {
            prop_assert!(degrees(tint.hue, 27.0) && (0.85..=1.15).contains(&tint.brightness));
        }
        prop_assert!(degrees(motion.turn_bias, 4.0) && motion.step_bias.abs() <= 0.08);
        prop_assert_eq!(odometry.step_drift.abs(), 0.02);
        prop_assert!((0.3..=2.0).contains(&obstacles.speed));
    }
}

#[test]
fn drawn_values_are_uniform_and_independent() {
    let reality = Reality::of(Randomization::Strong);
    let drawn: Vec<Conditions> = (0..4000).map(|key| Conditions::draw(&reality, key)).collect();
    let gains = || drawn.iter().map(|conditions| conditions.camera.gain);
    let biases = || drawn.iter().map(|conditions| conditions.motion.step_bias);
    let (mean, deviation) = moments(gains());
    // A uniform distribution of width w has the standard deviation w / sqrt(12).
    assert!((mean - 1.05).abs() < 0.015 && (deviation - 0.9 / 12_f64.sqrt()).abs() < 0.01);
    let (mean, deviation) = moments(biases());
    assert!(mean.abs() < 0.003 && (deviation - 0.16 / 12_f64.sqrt()).abs() < 0.002);
    let products = gains().zip(biases()).map(|(gain, bias)| (gain - 1.05) * bias);
    assert!(moments(products).0.abs() < 0.001);
    let stops = drawn.iter().filter(|conditions| conditions.motion.stops_short).count();
    assert!((1880..2120).contains(&stops), "{stops} of 4000 episodes stop short");
}

#[test]
fn the_noise_of_turns_and_steps_has_the_given_deviation() {
    let mut reality = Reality::default();
    (reality.motion.turn_noise, reality.motion.step_noise) = (6.0, 0.08);
    let conditions = Conditions::draw(&reality, 5);
    let moves: Vec<(f64, f64)> =
        (1..=8000).map(|step| conditions.motion(Action::ALL[1], step)).collect();
    let (mean, deviation) = moments(moves.iter().map(|(turn, _)| turn.to_degrees()));
    assert!((mean + 90.0).abs() < 0.3 && (deviation - 6.0).abs() < 0.2, "{mean} ± {deviation}");
    let (mean, deviation) = moments(moves.iter().map(|(_, distance)| distance / STEP_LENGTH));
    assert!((mean - 1.0).abs() < 0.004 && (deviation - 0.08).abs() < 0.003, "{mean} ± {deviation}");
}

#[test]
fn the_noise_of_the_camera_has_the_given_deviation_and_differs_between_images() {
    let mut reality = Reality::default();
    reality.camera.noise = 10.0;
    let conditions = Conditions::draw(&reality, 5);
    let exposed = |step, frame| {
        let mut bytes = [128; Frame::LENGTH];
        conditions.expose(&mut bytes, step, frame);
        bytes
    };
    let levels = (0..200).flat_map(|step| exposed(step, 0)).map(f64::from);
    let (mean, deviation) = moments(levels);
    assert!((mean - 128.0).abs() < 0.1 && (deviation - 10.0).abs() < 0.1, "{mean} ± {deviation}");
    assert_eq!(exposed(3, 1), exposed(3, 1));
    assert_ne!(exposed(3, 1), exposed(3, 0));
    assert_ne!(exposed(3, 0), exposed(4, 0));
}

#[test]
fn brightness_and_white_balance_saturate() {
    let mut reality = Reality::default();
    reality.camera.gain = Interval::only(2.0);
    let conditions = Conditions::draw(&reality, 1);
    let mut bytes = [0, 100, 200];
    conditions.expose(&mut bytes, 0, 0);
    assert_eq!(bytes, [0, 200, 255]);
}

#[test]
fn a_lost_image_is_replaced_by_the_one_before() {
    let mut reality = Reality::default();
    reality.camera.drop_rate = 0.3;
    let (mut lost, mut steps) = (0, 0);
    for seed in 1..=40 {
        let clean = episode(Reality::default(), Scenario::Empty, seed);
        let lossy = episode(reality, Scenario::Empty, seed);
        assert_eq!(clean[0], lossy[0], "the first image is never lost");
        for (index, window) in lossy.windows(2).enumerate() {
            let (before, now) = (window[0], window[1]);
            assert!(now.0 == before.0 || now.0 == clean[index + 1].0);
            assert_eq!(now.1, clean[index + 1].1, "the robot moves in any case");
            lost += usize::from(now.0 != clean[index + 1].0);
            steps += usize::from(clean[index].0 != clean[index + 1].0);
        }
    }
    let rate = lost as f64 / steps as f64;
    assert!((0.2..0.45).contains(&rate), "{lost} of {steps} images were lost");
}

/// Switches one perturbation on, with its strength from `strong`.
type Perturbation = fn(&mut Reality, strong: &Reality);

const BIAS: Perturbation = |reality, strong| {
    reality.motion.turn_bias = strong.motion.turn_bias;
    reality.motion.step_bias = strong.motion.step_bias;
};
const LIGHT: Perturbation = |reality, strong| reality.surfaces = strong.surfaces;
const PERTURBATIONS: [Perturbation; 15] = [
    BIAS,
    LIGHT,
    |reality, strong| reality.camera.noise = strong.camera.noise,
    |reality, strong| reality.camera.gain = strong.camera.gain,
    |reality, strong| reality.camera.color = strong.camera.color,
    |reality, strong| reality.camera.pitch = strong.camera.pitch,
    |reality, strong| reality.camera.roll = strong.camera.roll,
    |reality, strong| reality.camera.yaw = strong.camera.yaw,
    |reality, strong| reality.camera.height = strong.camera.height,
    |reality, strong| reality.camera.lens = strong.camera.lens,
    |reality, strong| reality.camera.drop_rate = strong.camera.drop_rate,
    |reality, strong| reality.motion.turn_noise = strong.motion.turn_noise,
    |reality, strong| reality.motion.step_noise = strong.motion.step_noise,
    |reality, strong| reality.motion.blocked = strong.motion.blocked,
    |reality, strong| reality.obstacles = strong.obstacles,
];

fn alone(perturbation: Perturbation) -> Reality {
    let mut reality = Reality::default();
    perturbation(&mut reality, &Reality::of(Randomization::Strong));
    reality
}

#[test]
fn one_perturbation_does_not_change_the_draws_of_another() {
    let strong = Reality::of(Randomization::Strong);
    let all = Conditions::draw(&strong, 9);
    let bias = Conditions::draw(&alone(BIAS), 9);
    assert_eq!(bias.motion.turn_bias, all.motion.turn_bias);
    assert_eq!((bias.camera, bias.motion.turn_noise), (CameraConditions::default(), 0.0));
    let light = Conditions::draw(&alone(LIGHT), 9);
    assert_eq!((light.light, light.surfaces), (all.light, all.surfaces));
}

#[test]
fn each_perturbation_changes_the_images_or_the_motion() {
    for (index, perturbation) in PERTURBATIONS.into_iter().enumerate() {
        let changed = (1..=30).any(|seed| {
            let reality = alone(perturbation);
            let scenario = Scenario::ThreeMoving;
            episode(reality, scenario, seed) != episode(Reality::default(), scenario, seed)
        });
        assert!(changed, "perturbation {index}");
    }
}

#[test]
fn odometry_drifts_from_the_true_pose_and_states_its_variance() {
    let odometry = OdometryReality { noise: 0.05, drift: 0.02 };
    let reality = Reality { odometry, ..Reality::default() };
    let layout = Layout::from_lists(&[0.0, 1.0], &[], &[0.0, 0.0, 0.0]).unwrap();
    let mut simulations = [reality, Reality::default()].map(|reality| {
        let mut simulation = simulation(reality, Scenario::Empty, 4);
        simulation.set_layout(layout.clone());
        simulation.reset(NonZeroU64::new(4), None).unwrap();
        assert_eq!(*simulation.odometry(), Odometry::at(*simulation.world().robot()));
        simulation
    });
    for simulation in &mut simulations {
        // An octagon with sides of one step, away from all walls.
        for _ in 0..8 {
            assert!(!simulation.step(Action::ALL[4]).unwrap().blocked);
        }
    }
    let [drifting, exact] = simulations;
    let estimate = drifting.odometry();
    let error = estimate.pose.inv_mul(drifting.world().robot());
    let (position, heading) = (error.translation.vector.norm(), error.rotation.angle().abs());
    // A systematic error of 2 % of two pi, plus the noise of eight turns, 0.05 * pi / 4 each.
    assert!((0.01..0.5).contains(&heading), "{heading}");
    assert!((0.005..0.3).contains(&position), "{position}");
    assert_eq!(exact.odometry().pose, *exact.world().robot());
}

#[test]
fn the_covariance_of_the_odometry_is_that_of_its_errors() {
    let odometry = OdometryReality { noise: 0.05, drift: 0.02 };
    let reality = Reality { odometry, ..Reality::default() };
    let (mut errors, mut stated) = (Vec::new(), nalgebra::Matrix3::zeros());
    for key in 0..4000 {
        let conditions = Conditions::draw(&reality, key);
        let mut truth = Isometry2::identity();
        let mut estimate = Odometry::at(truth);
        for step in 1..=15 {
            let before = truth;
            let turn = if step % 3 == 0 { -0.8 } else { 0.8 };
            truth.append_rotation_wrt_center_mut(&UnitComplex::new(turn));
            truth.translation.vector += truth.rotation * Vector2::new(STEP_LENGTH, 0.0);
            estimate.follow(&before, &truth, &conditions, step);
        }
        let position = estimate.pose.translation.vector - truth.translation.vector;
        let heading = truth.rotation.rotation_to(&estimate.pose.rotation).angle();
        errors.push(nalgebra::Vector3::new(position.x, position.y, heading));
        stated += estimate.covariance() / 4000.0;
    }
    for axis in 0..3 {
        let (_, deviation) = moments(errors.iter().map(|error| error[axis]));
        let ratio = deviation / stated[(axis, axis)].sqrt();
        assert!((0.93..1.07).contains(&ratio), "axis {axis}: {ratio}");
    }
    let product = moments(errors.iter().map(|error| error[0] * error[2])).0;
    let ratio = product / stated[(0, 2)];
    assert!((0.85..1.15).contains(&ratio), "x and heading: {ratio}");
}

#[test]
fn episodes_without_a_seed_have_different_conditions() {
    let settings =
        WorldSettings { reality: Reality::of(Randomization::Mild), ..WorldSettings::default() };
    let mut world = World::new(settings, Scenario::Empty, 0).unwrap();
    let first = world.conditions().clone();
    world.reset(None, None).unwrap();
    assert_ne!(*world.conditions(), first);
}

#[test]
fn intervals_are_parsed_and_printed() {
    for list in [&[0.0][..], &[3.0], &[0.8, 1.25], &[-1.0, 2.0]] {
        assert_eq!(Interval::from_list(list).unwrap().to_list(), list);
    }
    for (list, message) in [
        (&[][..], "invalid length 0 (expected: [r] for -r to r, or [low, high])"),
        (&[-1.0], "invalid half width -1 (expected: a finite number >= 0)"),
        (&[2.0, 1.0], "invalid limits 2 and 1 (expected: finite numbers, the lower limit first)"),
    ] {
        assert_eq!(Interval::from_list(list).unwrap_err().to_string(), message);
    }
}

#[test]
fn names_round_trip() {
    for level in Randomization::ALL {
        assert_eq!(level.to_string().parse(), Ok(level));
    }
    for motion in BlockedMotion::ALL {
        assert_eq!(motion.to_string().parse(), Ok(motion));
    }
    assert_eq!(
        "medium".parse::<Randomization>().unwrap_err().to_string(),
        "randomization: unknown value 'medium' (expected: none, mild, strong)"
    );
}
