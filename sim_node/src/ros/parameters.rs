//! The node's parameters.

use anyhow::Context;
use ros_runtime::parameters::{Descriptor, ParameterError, Parameters};

use crate::{
    camera::{Camera, CameraSettings},
    world::{Layout, Scenario, WorldSettings},
};

/// What the room is like.
pub struct RoomParameters {
    /// The scenario to begin with.
    pub scenario: Scenario,
    /// What the world is like in all of them.
    pub world: WorldSettings,
    /// The camera on its mount.
    pub camera: Camera,
    /// The seed of the simulator's own random state.
    pub seed: u64,
}

/// Declares what makes the room.
pub fn declare_room(parameters: &Parameters) -> anyhow::Result<RoomParameters> {
    let scenario = parameters.declare(
        "scenario",
        Scenario::Empty.name().to_owned(),
        Descriptor::dynamic("the scenario of resets that name none, from the next one on")
            .choices(Scenario::ALL.map(Scenario::name)),
    )?;
    let defaults = WorldSettings::default();
    let seed = parameters.declare(
        "seed",
        0_i64,
        Descriptor::read_only("where the simulator's own random state starts")
            .range(0.0..=((1_u64 << 53) - 1) as f64),
    )?;
    let max_steps = parameters.declare(
        "max_steps",
        i64::from(defaults.max_steps),
        Descriptor::read_only("an episode is truncated after so many steps")
            .range(1.0..=f64::from(u32::MAX)),
    )?;
    let heading_deviation = parameters.declare(
        "heading_deviation",
        defaults.heading_deviation,
        Descriptor::read_only(
            "standard deviation of the angle by which a moving cylinder turns at each step, in radians",
        )
        .range(0.0..=100.0),
    )?;
    let list = |name, description| -> Result<Vec<f64>, ParameterError> {
        parameters.declare(name, Vec::new(), Descriptor::read_only(description))
    };
    let layout = Layout::from_parameters(
        &list(
            "fixed_exit",
            "[wall, offset]: wall 0 to 3 for +x, +y, -x, -y; metres; empty: random",
        )?,
        &list("fixed_cylinders", "[x, y, ...] of the centres in metres; empty: random")?,
        &list("fixed_robot", "[x, y, yaw] in metres and radians; empty: random")?,
    )?;
    let camera = declare_camera(parameters)?;
    let world = WorldSettings { max_steps: max_steps as u32, heading_deviation, layout };
    Ok(RoomParameters { scenario: scenario.parse()?, world, camera, seed: seed as u64 })
}

fn declare_camera(parameters: &Parameters) -> anyhow::Result<Camera> {
    let defaults = CameraSettings::default();
    let number = |name, default, description| -> Result<f64, ParameterError> {
        parameters.declare(name, default, Descriptor::read_only(description))
    };
    let settings = CameraSettings {
        forward: number("camera.forward", defaults.forward, "ahead of the robot's centre, metres")?,
        left: number("camera.left", defaults.left, "left of the robot's centre, metres")?,
        height: number("camera.height", defaults.height, "above the floor, metres")?,
        pitch: number("camera.pitch", defaults.pitch, "downwards, radians")?,
    };
    Camera::new(settings).context("the parameters camera.*")
}
