//! Measures the simulator in this process: motion, collision checks and camera.

use std::{num::NonZeroU64, time::Instant};

use sim_node::{
    camera::{Camera, CameraSettings},
    world::{World, WorldSettings},
};
use task::{Action, Scenario};

use crate::quantile::median;

const ROUNDS: usize = 15;
const STEPS_A_ROUND: u32 = 20_000;

/// The measurements of one scenario.
pub struct RoomFigures {
    pub scenario: Scenario,
    /// Median number of steps per second, including resets and the rendering of each step's image.
    pub steps_per_s: f64,
}

pub fn measure() -> anyhow::Result<Vec<RoomFigures>> {
    Scenario::ALL
        .into_iter()
        .map(|scenario| Ok(RoomFigures { scenario, steps_per_s: steps_per_s(scenario)? }))
        .collect()
}

fn steps_per_s(scenario: Scenario) -> anyhow::Result<f64> {
    let mut world = World::new(WorldSettings::default(), scenario, 1)?;
    let camera = Camera::new(CameraSettings::default())?;
    let mut seed = NonZeroU64::MIN;
    let mut rates = Vec::new();
    let mut random = 1u32;
    for _ in 0..ROUNDS {
        let started = Instant::now();
        for _ in 0..STEPS_A_ROUND {
            // A linear congruential generator: random actions at negligible cost.
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let outcome = world.step(Action::try_from((random >> 24) as u8 % 7)?)?;
            std::hint::black_box(camera.render(&world));
            if outcome.terminated || outcome.truncated {
                seed = seed.saturating_add(1);
                world.reset(Some(seed), None)?;
            }
        }
        rates.push(f64::from(STEPS_A_ROUND) / started.elapsed().as_secs_f64());
    }
    Ok(median(&mut rates))
}
