//! World and learner in one process: what a run over DDS must equal to the byte.

use std::num::NonZeroU64;

use sim_node::{
    camera::{Camera, CameraSettings},
    world::{World, WorldSettings},
};
use task::{Action, Environment, Image, Scenario, Step};

/// The simulator's world and camera, without the simulator.
pub struct Room {
    world: World,
    camera: Camera,
}

impl Room {
    /// A room like that of a `sim_node` with these settings.
    pub fn new(settings: WorldSettings) -> Room {
        let world = World::new(settings, Scenario::Empty, 0).expect("nothing is held fixed");
        let camera = Camera::new(CameraSettings::default()).expect("the default mount is possible");
        Room { world, camera }
    }

    fn image(&self) -> Image {
        let frame = self.camera.render(&self.world);
        Image::try_from(frame.bytes().as_slice()).expect("both sides know the same camera")
    }
}

/// Why a room does not do what is asked of it.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct RoomError(#[from] anyhow::Error);

impl Environment for Room {
    type Error = RoomError;
    type PendingReset = Image;
    type PendingStep = Step;

    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<Image, RoomError> {
        let scenario: Scenario = scenario.parse().map_err(anyhow::Error::from)?;
        self.world.reset(Some(seed), Some(scenario)).map_err(anyhow::Error::from)?;
        Ok(self.image())
    }

    fn finish_reset(&mut self, pending: Image) -> Result<Image, RoomError> {
        Ok(pending)
    }

    fn begin_step(&mut self, action: Action) -> Result<Step, RoomError> {
        let outcome = self.world.step(action).map_err(anyhow::Error::from)?;
        Ok(Step {
            image: self.image(),
            reward: outcome.reward,
            terminated: outcome.terminated,
            truncated: outcome.truncated,
            blocked: outcome.blocked,
        })
    }

    fn finish_step(&mut self, pending: Step) -> Result<Step, RoomError> {
        Ok(pending)
    }
}
