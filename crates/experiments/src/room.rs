//! The simulator as an environment in this process: the reference that a run over DDS must match
//! byte for byte.

use std::num::NonZeroU64;

use sim_node::{
    Simulation,
    camera::{Camera, CameraSettings},
    world::{World, WorldSettings},
};
use task::{Action, Environment, Image, Scenario, Step};

/// The simulation of `sim_node` without its ROS interface.
pub struct Room(Simulation);

impl Room {
    /// Creates the environment that a `sim_node` with these settings serves. The camera has its
    /// default settings.
    ///
    /// # Panics
    ///
    /// Panics if the settings specify an impossible fixed layout.
    pub fn new(settings: WorldSettings) -> Room {
        let world = World::new(settings, Scenario::Empty, 0).expect("the layout is possible");
        let camera = Camera::new(CameraSettings::default()).expect("the defaults are valid");
        Room(Simulation::new(world, camera))
    }

    fn image(&self) -> Image {
        let frame = self.0.frame(0);
        Image::try_from(frame.bytes().as_slice()).expect("frame and image have the same size")
    }
}

/// The error of a reset or step: an unknown scenario, an impossible layout, or a step after the end
/// of the episode.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct RoomError(#[from] anyhow::Error);

impl Environment for Room {
    type Error = RoomError;
    type PendingReset = Image;
    type PendingStep = Step;

    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<Image, RoomError> {
        let scenario: Scenario = scenario.parse().map_err(anyhow::Error::from)?;
        self.0.reset(Some(seed), Some(scenario)).map_err(anyhow::Error::from)?;
        Ok(self.image())
    }

    fn finish_reset(&mut self, pending: Image) -> Result<Image, RoomError> {
        Ok(pending)
    }

    fn begin_step(&mut self, action: Action) -> Result<Step, RoomError> {
        let outcome = self.0.step(action).map_err(anyhow::Error::from)?;
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
