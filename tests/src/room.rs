//! World and learner in one process: what a run over DDS must equal to the byte.

use std::num::NonZeroU64;

use agent_node::{
    environment::{Environment, EnvironmentError, Step},
    learning::dyna_q::Decision,
};
use sim_node::{
    camera::{Camera, CameraSettings},
    world::{World, WorldSettings},
};
use task::{Action, Image, Scenario};

/// The simulator's world and camera, without the simulator.
pub struct Room {
    world: World,
    camera: Camera,
    action: Option<Action>,
}

impl Room {
    /// A room like that of a `sim_node` with these settings.
    pub fn new(settings: WorldSettings) -> Room {
        let world = World::new(settings, Scenario::Empty, 0).expect("nothing is held fixed");
        let camera = Camera::new(CameraSettings::default()).expect("the default mount is possible");
        Room { world, camera, action: None }
    }

    fn image(&self) -> Image {
        let frame = self.camera.render(&self.world);
        Image::try_from(frame.bytes().as_slice()).expect("both sides know the same camera")
    }
}

impl Environment for Room {
    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<(), EnvironmentError> {
        let refused = |error: String| EnvironmentError::Refused(error);
        let scenario: Scenario = scenario.parse().map_err(|error| refused(format!("{error}")))?;
        self.world.reset(Some(seed), Some(scenario)).map_err(|error| refused(error.to_string()))?;
        Ok(())
    }

    fn finish_reset(&mut self) -> Result<Image, EnvironmentError> {
        Ok(self.image())
    }

    fn begin_step(&mut self, decision: &Decision) -> Result<(), EnvironmentError> {
        self.action = Some(decision.action);
        Ok(())
    }

    fn finish_step(&mut self) -> Result<Step, EnvironmentError> {
        let refused = |error: String| EnvironmentError::Refused(error);
        let action = self.action.take().ok_or_else(|| refused("no step was begun".into()))?;
        let outcome = self.world.step(action).map_err(|error| refused(error.to_string()))?;
        Ok(Step {
            image: self.image(),
            reward: outcome.reward,
            terminated: outcome.terminated,
            truncated: outcome.truncated,
            blocked: outcome.blocked,
        })
    }
}
