//! Tests that steps and frames do not allocate, so memory does not grow and no step waits for the
//! allocator.

use std::num::NonZeroU64;

use evac_msgs::step;
use sim_node::{
    Simulation,
    camera::{Camera, CameraSettings},
    ros::Session,
    world::{Layout, World, WorldSettings},
};
use task::{Action, Scenario};

#[test]
fn steps_and_frames_do_not_allocate() {
    let camera = Camera::new(CameraSettings::default()).unwrap();
    for scenario in Scenario::ALL {
        let mut world = World::new(WorldSettings::default(), scenario, 1).unwrap();
        let mut seed = NonZeroU64::MIN;
        for number in 0..5000 {
            // A deterministic sequence that reaches walls, obstacles and the exit.
            let action = Action::ALL[(number * number / 7) % Action::COUNT];
            let allocated = allocation_counter::measure(|| {
                world.step(action).unwrap();
                std::hint::black_box(camera.render(&world));
            });
            assert_eq!(allocated.count_total, 0, "{scenario}, step {number}");
            if world.is_over() {
                seed = seed.saturating_add(1);
                world.reset(Some(seed), None).unwrap();
            }
        }
    }
}

/// A response allocates memory only for its own message, because the session allocates the memory
/// for the episode's path at the start.
#[test]
fn a_response_allocates_as_much_at_the_end_of_an_episode_as_at_its_start() {
    // The robot faces a wall: every step is blocked, so the episode reaches its step limit.
    let layout = Layout::from_lists(&[2.0, 0.0], &[], &[1.15, 0.0, 0.0]).unwrap();
    let settings = WorldSettings { layout, ..WorldSettings::default() };
    let world = World::new(settings, Scenario::Empty, 1).unwrap();
    let camera = Camera::new(CameraSettings::default()).unwrap();
    let (mut session, _) = Session::new(Simulation::new(world, camera), 0.5);
    let mut execute_step = || {
        let request = step::Request { action: 3, ..step::Request::default() };
        let (response, _) = session.step(&request);
        assert!(response.blocked);
        response.truncated
    };
    let mut counts = Vec::with_capacity(10_000);
    let mut truncated = false;
    while !truncated {
        let allocated = allocation_counter::measure(|| truncated = execute_step());
        counts.push(allocated.count_total);
    }
    assert_eq!(counts.len(), 10_000);
    assert_eq!(counts, vec![counts[0]; 10_000]);
}
