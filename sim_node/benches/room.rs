//! Benchmarks of the simulator without ROS: `cargo bench --package sim_node`.

use std::num::NonZeroU64;

use divan::Bencher;
use sim_node::{
    camera::{Camera, CameraSettings, Frame},
    world::{World, WorldSettings},
};
use task::{Action, Scenario};

fn main() {
    divan::main();
}

fn world(scenario: Scenario) -> World {
    World::new(WorldSettings::default(), scenario, 1).expect("a random layout is valid")
}

fn camera() -> Camera {
    Camera::new(CameraSettings::default()).expect("the default settings are valid")
}

/// Measures a step and the frame after it, plus a reset when an episode ends.
#[divan::bench(args = Scenario::ALL, sample_size = 1000)]
fn step_with_frame(bencher: Bencher, scenario: Scenario) {
    let (mut world, camera) = (world(scenario), camera());
    let mut actions = Action::ALL.into_iter().cycle();
    bencher.bench_local(|| -> Frame {
        if world.is_over() {
            world.reset(None, None).expect("a random layout is valid");
        }
        let action = actions.next().expect("a cycle is endless");
        world.step(action).expect("the episode is not over");
        camera.render(&world)
    });
}

#[divan::bench(args = Scenario::ALL, sample_size = 1000)]
fn frame(bencher: Bencher, scenario: Scenario) {
    let (world, camera) = (world(scenario), camera());
    bencher.bench_local(|| camera.render(&world));
}

#[divan::bench(args = Scenario::ALL, sample_size = 1000)]
fn reset(bencher: Bencher, scenario: Scenario) {
    let mut world = world(scenario);
    let mut seed = NonZeroU64::MIN;
    bencher.bench_local(|| {
        seed = seed.saturating_add(1);
        world.reset(Some(seed), None)
    });
}
