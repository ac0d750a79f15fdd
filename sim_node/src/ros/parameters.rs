//! The parameters of the node.

use anyhow::Context;
use ros_runtime::parameters::{Check, ParameterError, ParameterValue, Parameters};
use task::Scenario;

use super::{
    descriptors::{at_next_reset, at_start},
    reality_parameters,
};
use crate::{
    camera::{Camera, CameraSettings},
    world::{Layout, LayoutError, WorldSettings},
};

/// The parameters of the simulated world.
pub struct RoomParameters {
    /// Scenario of the first episode.
    pub scenario: Scenario,
    /// World settings for all scenarios.
    pub world: WorldSettings,
    /// Camera with the mount given by the `camera.*` parameters.
    pub camera: Camera,
    /// Seed of the simulator's own random state.
    pub seed: u64,
}

/// The parameters that make the simulator behave like a robot.
pub struct DeploymentParameters {
    /// Rate, in Hz of wall-clock time, at which images are published in addition to the image after
    /// each reset or step; 0 for none.
    pub frame_rate: f64,
    /// Whether the next episode starts automatically after one controlled through `/action`.
    pub auto_reset: bool,
    /// Duration of a move, in seconds of wall-clock time; 0 for instantaneous moves.
    pub motion_time: f64,
}

/// All parameters of the node.
pub struct SimulatorParameters {
    /// Parameters of the simulated world.
    pub room: RoomParameters,
    /// Simulated duration of a step or reset, in seconds.
    pub step_duration: f64,
    /// Parameters that make the simulator behave like a robot.
    pub deployment: DeploymentParameters,
}

impl SimulatorParameters {
    /// Declares all parameters of the node.
    ///
    /// # Errors
    ///
    /// Returns an error if a value is invalid or an override names an unknown parameter.
    pub fn declare(parameters: &Parameters) -> anyhow::Result<SimulatorParameters> {
        let room = declare_room(parameters)?;
        let step_duration = parameters.declare(
            "step_duration",
            0.5,
            at_start(
                "simulated duration of a step or reset, in seconds; simulated time follows the \
                 wall clock instead if frame_rate or motion_time is above 0",
            )
            .range(1e-9..=3600.0),
        )?;
        let deployment = DeploymentParameters::declare(parameters)?;
        parameters.reject_undeclared()?;
        Ok(SimulatorParameters { room, step_duration, deployment })
    }
}

impl DeploymentParameters {
    /// Declares the parameters.
    ///
    /// # Errors
    ///
    /// Returns an error if a value is invalid.
    pub fn declare(parameters: &Parameters) -> Result<DeploymentParameters, ParameterError> {
        Ok(DeploymentParameters {
            frame_rate: parameters.declare(
                "frame_rate",
                0.0,
                at_start(
                    "rate, in Hz of wall-clock time, at which images are published in addition to \
                     the image after each reset or step; 0 for none; if above 0, simulated time \
                     follows the wall clock",
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
                at_start("start a new episode when one controlled through the /action topic ends"),
            )?,
            motion_time: parameters.declare(
                "motion_time",
                0.0,
                at_start(
                    "duration of a move, in seconds of wall-clock time; the response and the image \
                     are sent when the move ends; if above 0, simulated time follows the wall \
                     clock",
                )
                .range(0.0..=60.0),
            )?,
        })
    }

    /// Returns whether the simulated time follows the wall clock.
    pub fn is_in_real_time(&self) -> bool {
        self.frame_rate > 0.0 || self.motion_time > 0.0
    }
}

/// Declares the parameters of the simulated world.
///
/// # Errors
///
/// Returns an error if a value is invalid.
pub fn declare_room(parameters: &Parameters) -> anyhow::Result<RoomParameters> {
    let scenario = parameters.declare(
        "scenario",
        Scenario::Empty.name().to_owned(),
        at_next_reset(
            "scenario for resets whose request does not name one; a request that names a scenario \
             sets this parameter",
        )
        .choices(Scenario::ALL.map(Scenario::name)),
    )?;
    let defaults = WorldSettings::default();
    let seed = parameters.declare(
        "seed",
        0_i64,
        at_start("seed of the simulator's own random state, used by resets without a seed")
            .range(0.0..=((1_u64 << 53) - 1) as f64),
    )?;
    let max_steps = parameters.declare(
        "max_steps",
        i64::from(defaults.max_steps),
        at_start("number of steps after which an episode is truncated")
            .range(1.0..=f64::from(u32::MAX)),
    )?;
    let heading_deviation = parameters.declare(
        "heading_deviation",
        defaults.heading_deviation,
        at_start(
            "standard deviation, in radians, of the angle by which a moving cylinder turns at each \
             step",
        )
        .range(0.0..=100.0),
    )?;
    declare_layout(parameters)?;
    let layout = layout(parameters)?;
    let camera = declare_camera(parameters)?;
    let reality = reality_parameters::declare(parameters)?;
    let world = WorldSettings { max_steps: max_steps as u32, heading_deviation, layout, reality };
    Ok(RoomParameters { scenario: scenario.parse()?, world, camera, seed: seed as u64 })
}

const FIXED_EXIT: &str = "fixed_exit";
const FIXED_CYLINDERS: &str = "fixed_cylinders";
const FIXED_ROBOT: &str = "fixed_robot";

/// Declares the parameters of the fixed layout.
///
/// Each list is checked individually when it is set. The next reset checks whether the lists are
/// compatible with each other and with the scenario.
fn declare_layout(parameters: &Parameters) -> Result<(), ParameterError> {
    let list = |name, description: &str, check: Check| {
        let descriptor = at_next_reset(description).check(check);
        parameters.declare(name, Vec::<f64>::new(), descriptor).map(drop)
    };
    list(
        FIXED_EXIT,
        "fixed exit [wall, offset]: wall 0 to 3 for +x, +y, -x, -y; offset from the middle of the \
         wall in metres, -1 to 1; empty for a random exit",
        |value| check_layout(numbers(value), &[], &[]),
    )?;
    list(
        FIXED_CYLINDERS,
        "fixed centres [x, y, ...] of all cylinders of the scenario, in metres; empty for random \
         centres",
        |value| check_layout(&[], numbers(value), &[]),
    )?;
    list(
        FIXED_ROBOT,
        "fixed start pose [x, y, yaw] of the robot, in metres and radians; empty for a random pose",
        |value| check_layout(&[], &[], numbers(value)),
    )
}

fn check_layout(exit: &[f64], cylinders: &[f64], robot: &[f64]) -> Result<(), String> {
    Layout::from_lists(exit, cylinders, robot).map(drop).map_err(|error| error.to_string())
}

/// Returns the numbers of a list. The value passed to a check always has the declared type.
fn numbers(value: &ParameterValue) -> &[f64] {
    match value {
        ParameterValue::DoubleArray(numbers) => numbers,
        _ => &[],
    }
}

/// Returns the fixed layout that the parameters currently describe.
pub(super) fn layout(parameters: &Parameters) -> Result<Layout, LayoutError> {
    let list = |name| parameters.get::<Vec<f64>>(name).unwrap_or_default();
    Layout::from_lists(&list(FIXED_EXIT), &list(FIXED_CYLINDERS), &list(FIXED_ROBOT))
}

fn declare_camera(parameters: &Parameters) -> anyhow::Result<Camera> {
    let defaults = CameraSettings::default();
    let number = |name, default, description| -> Result<f64, ParameterError> {
        parameters.declare(name, default, at_start(description))
    };
    let settings = CameraSettings {
        forward: number(
            "camera.forward",
            defaults.forward,
            "distance of the camera ahead of the robot's centre, in metres, -0.075 to 0.075",
        )?,
        left: number(
            "camera.left",
            defaults.left,
            "distance of the camera to the left of the robot's centre, in metres, -0.075 to 0.075",
        )?,
        height: number(
            "camera.height",
            defaults.height,
            "height of the camera above the floor, in metres, above 0 and below 0.25",
        )?,
        pitch: number(
            "camera.pitch",
            defaults.pitch,
            "downward pitch of the camera, in radians, -pi/2 to pi/2",
        )?,
    };
    Camera::new(settings).context("camera.* parameters")
}

#[cfg(test)]
pub(super) mod tests {
    use ros_runtime::{Arguments, names::Naming};

    use super::*;

    /// Returns parameters with the overrides of a command line; none is declared yet.
    pub(in crate::ros) fn parameters(line: &str) -> Parameters {
        let line = format!("sim_node --ros-args {line}");
        let arguments = Arguments::parse(line.split_whitespace().map(str::to_owned)).unwrap();
        let naming = Naming::new("sim_node", &arguments.remaps).unwrap();
        Parameters::new(&naming, &arguments).unwrap()
    }

    fn list(numbers: &[f64]) -> ParameterValue {
        ParameterValue::DoubleArray(numbers.to_vec())
    }

    #[test]
    fn the_fixed_layout_can_be_changed_while_the_node_runs() {
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
    fn the_error_for_an_invalid_list_states_the_expected_format() {
        let parameters = parameters("");
        declare_room(&parameters).unwrap();
        for (name, numbers, expected) in [
            (FIXED_EXIT, &[1.0][..], "expected: [wall, offset], or empty"),
            (FIXED_EXIT, &[1.0, 1.5], "within ±1 m"),
            (FIXED_EXIT, &[4.0, 0.0], "expected: 0 for +x, 1 for +y, 2 for -x, 3 for -y"),
            (FIXED_CYLINDERS, &[0.0, 0.0, 0.0], "two per cylinder"),
            (FIXED_ROBOT, &[0.0, 0.0], "expected: [x, y, yaw], or empty"),
            (FIXED_ROBOT, &[0.0, 0.0, f64::NAN], "not a finite number"),
        ] {
            let error = parameters.set(name, list(numbers)).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(expected), "{error}");
        }
        assert_eq!(layout(&parameters), Ok(Layout::default()));
    }
}
