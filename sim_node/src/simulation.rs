//! A world, the camera that sees it, and the odometry of the robot.

use std::num::NonZeroU64;

use task::{Action, Scenario};

use crate::{
    camera::{Camera, Frame},
    reality::{Odometry, Reality},
    world::{EpisodeOver, Layout, Outcome, PlacementError, World},
};

/// A world with its camera and the robot's odometry, all subject to the perturbations drawn for the
/// current episode.
///
/// # Examples
///
/// ```
/// use std::num::NonZeroU64;
///
/// use sim_node::{
///     Simulation,
///     camera::{Camera, CameraSettings},
///     reality::{Randomization, Reality},
///     world::{World, WorldSettings},
/// };
/// use task::{Action, Scenario};
///
/// let reality = Reality::of(Randomization::Strong);
/// let settings = WorldSettings { reality, ..WorldSettings::default() };
/// let world = World::new(settings, Scenario::Concave, 1)?;
/// let mut simulation = Simulation::new(world, Camera::new(CameraSettings::default())?);
/// simulation.reset(NonZeroU64::new(7), None)?;
/// let first = simulation.frame(0);
/// simulation.step(Action::ALL[3])?;
/// assert_ne!(simulation.frame(0), first);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Simulation {
    world: World,
    camera: Camera,
    odometry: Odometry,
    /// The latest image that was not lost; `None` if no images are lost in this episode.
    delivered: Option<Box<Frame>>,
}

impl Simulation {
    /// Creates a simulation of the current episode of `world`.
    pub fn new(world: World, camera: Camera) -> Simulation {
        let odometry = Odometry::at(*world.robot());
        let mut simulation = Simulation { world, camera, odometry, delivered: None };
        simulation.begin_episode();
        simulation
    }

    /// Returns the world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Returns the odometry of the robot.
    pub fn odometry(&self) -> &Odometry {
        &self.odometry
    }

    /// Sets the fixed layout for subsequent resets.
    pub fn set_layout(&mut self, layout: Layout) {
        self.world.set_layout(layout);
    }

    /// Sets the perturbations for subsequent resets.
    pub fn set_reality(&mut self, reality: Reality) {
        self.world.set_reality(reality);
    }

    /// Starts a new episode, as [`World::reset`] does.
    ///
    /// # Errors
    ///
    /// Same as [`World::reset`]. Nothing changes after an error.
    pub fn reset(
        &mut self,
        seed: Option<NonZeroU64>,
        scenario: Option<Scenario>,
    ) -> Result<(), PlacementError> {
        self.world.reset(seed, scenario)?;
        self.begin_episode();
        Ok(())
    }

    fn begin_episode(&mut self) {
        self.camera.adapt(self.world.conditions());
        self.odometry = Odometry::at(*self.world.robot());
        self.delivered = None;
        if self.world.conditions().camera.drop_rate > 0.0 {
            // The first image of an episode is never lost: there is no earlier one.
            self.delivered = Some(Box::new(self.exposed(0)));
        }
    }

    /// Executes an action, as [`World::step`] does.
    ///
    /// # Errors
    ///
    /// Returns an error if the episode is over.
    pub fn step(&mut self, action: Action) -> Result<Outcome, EpisodeOver> {
        let before = *self.world.robot();
        let outcome = self.world.step(action)?;
        let (conditions, step) = (self.world.conditions(), self.world.steps());
        self.odometry.follow(&before, self.world.robot(), conditions, step);
        if self.delivered.is_some() && !conditions.is_dropped(step, 0) {
            self.delivered = Some(Box::new(self.exposed(0)));
        }
        Ok(outcome)
    }

    /// Returns whether an image is lost. The first image of an episode is never lost. `frame` is the
    /// index of the image among those taken since the latest step; 0 is the image of that step.
    pub fn is_dropped(&self, frame: u32) -> bool {
        let step = self.world.steps();
        (step > 0 || frame > 0) && self.world.conditions().is_dropped(step, frame)
    }

    /// Returns an image. If image 0, that of the latest step, is lost, this is the latest image 0
    /// that was not. All others are returned whether they are lost or not.
    pub fn frame(&self, frame: u32) -> Frame {
        match &self.delivered {
            Some(delivered) if frame == 0 => **delivered,
            _ => self.exposed(frame),
        }
    }

    /// Writes an image to an existing buffer, for example that of a message, as
    /// [`frame`](Self::frame) returns it.
    pub fn frame_to(&self, frame: u32, bytes: &mut [u8; Frame::LENGTH]) {
        match &self.delivered {
            Some(delivered) if frame == 0 => bytes.copy_from_slice(delivered.bytes()),
            _ => self.expose_to(frame, bytes),
        }
    }

    fn exposed(&self, number: u32) -> Frame {
        let mut frame = Frame::default();
        self.expose_to(number, frame.bytes_mut());
        frame
    }

    fn expose_to(&self, frame: u32, bytes: &mut [u8; Frame::LENGTH]) {
        self.camera.render_to(&self.world, bytes);
        self.world.conditions().expose(bytes, self.world.steps(), frame);
    }
}
