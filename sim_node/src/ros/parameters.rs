//! The node's parameters.

use anyhow::Context;
use ros_runtime::parameters::{Check, Descriptor, ParameterError, ParameterValue, Parameters};
use task::Scenario;

use crate::{
    camera::{Camera, CameraSettings},
    world::{Layout, LayoutError, WorldSettings},
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

/// How the node takes a robot's place.
pub struct DeploymentParameters {
    /// How many images a second it sends besides those of resets and steps.
    pub frame_rate: f64,
    /// Whether the next episode begins by itself.
    pub auto_reset: bool,
    /// How long a move takes, in seconds.
    pub motion_time: f64,
}

/// All parameters of the node.
pub struct SimulatorParameters {
    /// What the room is like.
    pub room: RoomParameters,
    /// The simulated time of a step or reset, in seconds.
    pub step_duration: f64,
    /// How the node takes a robot's place.
    pub deployment: DeploymentParameters,
}

impl SimulatorParameters {
    /// Declares them, and refuses any other.
    pub fn declare(parameters: &Parameters) -> anyhow::Result<SimulatorParameters> {
        let room = declare_room(parameters)?;
        let step_duration = parameters.declare(
            "step_duration",
            0.5,
            Descriptor::read_only("simulated time of a step or reset, in seconds")
                .range(1e-9..=3600.0),
        )?;
        let deployment = DeploymentParameters::declare(parameters)?;
        parameters.refuse_undeclared()?;
        Ok(SimulatorParameters { room, step_duration, deployment })
    }
}

impl DeploymentParameters {
    /// Declares them.
    pub fn declare(parameters: &Parameters) -> Result<DeploymentParameters, ParameterError> {
        Ok(DeploymentParameters {
            frame_rate: parameters.declare(
                "frame_rate",
                0.0,
                Descriptor::read_only(
                    "images a second besides those of resets and steps, with new stamps; time is \
                     then that of the clock on the wall",
                )
                .range(0.0..=1000.0)
                .check(|value| match value {
                    ParameterValue::Double(rate) if *rate > 0.0 && *rate < 1e-3 => {
                        Err("expected 0 or at least 0.001".to_owned())
                    }
                    _ => Ok(()),
                }),
            )?,
            auto_reset: parameters.declare(
                "auto_reset",
                false,
                Descriptor::read_only("begin a new episode when one that /action moves is over"),
            )?,
            motion_time: parameters.declare(
                "motion_time",
                0.0,
                Descriptor::read_only(
                    "how long a move takes, in seconds by the clock on the wall; its answer and its \
                     image come at its end",
                )
                .range(0.0..=60.0),
            )?,
        })
    }

    /// Whether time is that of the clock on the wall.
    pub fn is_in_real_time(&self) -> bool {
        self.frame_rate > 0.0 || self.motion_time > 0.0
    }
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
    declare_layout(parameters)?;
    let layout = layout(parameters)?;
    let camera = declare_camera(parameters)?;
    let world = WorldSettings { max_steps: max_steps as u32, heading_deviation, layout };
    Ok(RoomParameters { scenario: scenario.parse()?, world, camera, seed: seed as u64 })
}

const FIXED_EXIT: &str = "fixed_exit";
const FIXED_CYLINDERS: &str = "fixed_cylinders";
const FIXED_ROBOT: &str = "fixed_robot";

/// Each list is refused alone if it says nothing. Whether what they say fits together, and into a
/// scenario, only the next reset can tell.
fn declare_layout(parameters: &Parameters) -> Result<(), ParameterError> {
    let list = |name, description: &str, check: Check| {
        let descriptor = Descriptor::dynamic(&format!("{description}; from the next reset on"));
        parameters.declare(name, Vec::<f64>::new(), descriptor.check(check)).map(drop)
    };
    list(
        FIXED_EXIT,
        "[wall, offset]: wall 0 to 3 for +x, +y, -x, -y; metres; empty: random",
        |value| check_layout(numbers(value), &[], &[]),
    )?;
    list(FIXED_CYLINDERS, "[x, y, ...] of the centres in metres; empty: random", |value| {
        check_layout(&[], numbers(value), &[])
    })?;
    list(FIXED_ROBOT, "[x, y, yaw] in metres and radians; empty: random", |value| {
        check_layout(&[], &[], numbers(value))
    })
}

fn check_layout(exit: &[f64], cylinders: &[f64], robot: &[f64]) -> Result<(), String> {
    Layout::from_lists(exit, cylinders, robot).map(drop).map_err(|error| error.to_string())
}

/// The numbers of a list; a check sees no other type than the declared one.
fn numbers(value: &ParameterValue) -> &[f64] {
    match value {
        ParameterValue::DoubleArray(numbers) => numbers,
        _ => &[],
    }
}

/// What the parameters hold fixed now.
pub(super) fn layout(parameters: &Parameters) -> Result<Layout, LayoutError> {
    let list = |name| parameters.get::<Vec<f64>>(name).unwrap_or_default();
    Layout::from_lists(&list(FIXED_EXIT), &list(FIXED_CYLINDERS), &list(FIXED_ROBOT))
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

#[cfg(test)]
mod tests {
    use ros_runtime::{Arguments, names::Naming};

    use super::*;

    fn parameters(line: &str) -> Parameters {
        let line = format!("sim_node --ros-args {line}");
        let arguments = Arguments::parse(line.split_whitespace().map(str::to_owned)).unwrap();
        let naming = Naming::new("sim_node", &arguments.remaps).unwrap();
        Parameters::new(&naming, &arguments).unwrap()
    }

    fn list(numbers: &[f64]) -> ParameterValue {
        ParameterValue::DoubleArray(numbers.to_vec())
    }

    #[test]
    fn what_is_fixed_can_be_changed_while_the_node_runs() {
        let parameters = parameters("-p fixed_exit:=[2,0.5]");
        let room = declare_room(&parameters).unwrap();
        let first = Layout::from_lists(&[2.0, 0.5], &[], &[]).unwrap();
        assert_eq!(room.world.layout, first);

        parameters.set(FIXED_EXIT, list(&[])).unwrap();
        parameters.set(FIXED_CYLINDERS, list(&[0.1, 0.2])).unwrap();
        parameters.set(FIXED_ROBOT, list(&[-0.5, 0.5, 1.0])).unwrap();
        let second = Layout::from_lists(&[], &[0.1, 0.2], &[-0.5, 0.5, 1.0]);
        assert_eq!(layout(&parameters), second);
    }

    #[test]
    fn a_list_that_says_nothing_is_refused_with_its_right_form() {
        let parameters = parameters("");
        declare_room(&parameters).unwrap();
        for (name, numbers, expected) in [
            (FIXED_EXIT, &[1.0][..], "it is [wall, offset], or empty"),
            (FIXED_EXIT, &[1.0, 1.5], "the offset is within ±1 m"),
            (FIXED_EXIT, &[4.0, 0.0], "a wall is 0 (+x), 1 (+y), 2 (-x) or 3 (-y)"),
            (FIXED_CYLINDERS, &[0.0, 0.0, 0.0], "two for each cylinder"),
            (FIXED_ROBOT, &[0.0, 0.0], "it is [x, y, yaw], or empty"),
            (FIXED_ROBOT, &[0.0, 0.0, f64::NAN], "not a finite number"),
        ] {
            let error = parameters.set(name, list(numbers)).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(expected), "{error}");
        }
        assert_eq!(layout(&parameters), Ok(Layout::default()));
    }
}
