//! A step and its frame allocate nothing: memory does not grow, and no step waits for the allocator.

use std::num::NonZeroU64;

use sim_node::{
    camera::{Camera, CameraSettings},
    world::{Action, Scenario, World, WorldSettings},
};

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
