//! A step and its frame allocate nothing: memory does not grow, and no step waits for the allocator.

use std::num::NonZeroU64;

use evac_msgs::step;
use sim_node::{
    camera::{Camera, CameraSettings},
    ros::Session,
    world::{Layout, World, WorldSettings},
};
use task::{Action, Scenario};

#[test]
fn a_step_and_its_frame_allocate_nothing() {
    let camera = Camera::new(CameraSettings::default()).unwrap();
    for scenario in Scenario::ALL {
        let mut world = World::new(WorldSettings::default(), scenario, 1).unwrap();
        let mut seed = NonZeroU64::MIN;
        for number in 0..5000 {
            // Whatever this sequence lacks in chance, it leads into walls, obstacles and the exit.
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

/// The messages are made for whoever asked and for whoever reads; what a session keeps of an episode
/// itself, its path, has its memory from the start.
#[test]
fn an_answer_allocates_no_more_at_the_end_of_an_episode_than_at_its_start() {
    // Ahead is the wall, so that the episode lasts.
    let layout = Layout::from_lists(&[2.0, 0.0], &[], &[1.15, 0.0, 0.0]).unwrap();
    let settings = WorldSettings { layout, ..WorldSettings::default() };
    let world = World::new(settings, Scenario::Empty, 1).unwrap();
    let camera = Camera::new(CameraSettings::default()).unwrap();
    let (mut session, _) = Session::new(world, camera, 0.5);
    let mut answer = || {
        let request = step::Request { action: 3, ..step::Request::default() };
        let (response, _) = session.step(&request);
        assert!(response.blocked);
        response.truncated
    };
    let mut counts = Vec::with_capacity(10_000);
    let mut truncated = false;
    while !truncated {
        let allocated = allocation_counter::measure(|| truncated = answer());
        counts.push(allocated.count_total);
    }
    assert_eq!(counts.len(), 10_000);
    assert_eq!(counts, vec![counts[0]; 10_000]);
}
