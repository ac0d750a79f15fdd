//! The parameters of the perturbations.

use anyhow::Context;
use ros_runtime::parameters::{Check, ParameterError, ParameterValue, Parameters};

use super::descriptors::at_next_reset;
use crate::reality::{BlockedMotion, Interval, Randomization, Reality};

const RANDOMIZATION: &str = "randomization";
const BLOCKED: &str = "motion.blocked";

/// A perturbation with a strength that is a number or an interval.
struct Row {
    name: &'static str,
    description: &'static str,
    field: Field,
}

/// The value of a parameter, its limits, and its field in [`Reality`].
enum Field {
    /// One number, from 0 to a maximum.
    Number(f64, fn(&mut Reality) -> &mut f64),
    /// An interval of errors, with the largest absolute value of its limits.
    Error(f64, fn(&mut Reality) -> &mut Interval),
    /// An interval of factors, with the largest one.
    Factor(f64, fn(&mut Reality) -> &mut Interval),
}

const ROWS: [Row; 19] = [
    Row {
        name: "camera.noise",
        description: "standard deviation of the Gaussian noise on each channel of each pixel, in \
                      grey levels of 255; new for each image",
        field: Field::Number(255.0, |reality| &mut reality.camera.noise),
    },
    Row {
        name: "camera.gain_range",
        description: "brightness factor of the images",
        field: Field::Factor(10.0, |reality| &mut reality.camera.gain),
    },
    Row {
        name: "camera.color_range",
        description: "factor of each colour channel (white balance)",
        field: Field::Factor(10.0, |reality| &mut reality.camera.color),
    },
    Row {
        name: "camera.pitch_range",
        description: "error of the downward pitch of the camera, in degrees",
        field: Field::Error(90.0, |reality| &mut reality.camera.pitch),
    },
    Row {
        name: "camera.roll_range",
        description: "error of the roll of the camera, in degrees; positive lowers its right side",
        field: Field::Error(90.0, |reality| &mut reality.camera.roll),
    },
    Row {
        name: "camera.yaw_range",
        description: "error of the yaw of the camera, in degrees; positive turns it to the left",
        field: Field::Error(90.0, |reality| &mut reality.camera.yaw),
    },
    Row {
        name: "camera.height_range",
        description: "error of the height of the camera, in metres; its height stays between 0.001 \
                      and 0.249 m",
        field: Field::Error(0.25, |reality| &mut reality.camera.height),
    },
    Row {
        name: "camera.lens_range",
        description: "relative error of the camera's field of view",
        field: Field::Error(0.5, |reality| &mut reality.camera.lens),
    },
    Row {
        name: "camera.latency",
        description: "time from exposure to publication of an image, in seconds; the stamp is that \
                      of the exposure; used only if simulated time follows the wall clock, and not \
                      for responses to services",
        field: Field::Number(10.0, |reality| &mut reality.camera.latency),
    },
    Row {
        name: "camera.drop_rate",
        description: "share of images that are lost: not published if simulated time follows the \
                      wall clock, otherwise replaced by the previous image, as in responses to \
                      services",
        field: Field::Number(1.0, |reality| &mut reality.camera.drop_rate),
    },
    Row {
        name: "light.direction_range",
        description: "error of the azimuth and of the elevation of the light, in degrees",
        field: Field::Error(180.0, |reality| &mut reality.surfaces.light_direction),
    },
    Row {
        name: "surface.color_range",
        description: "change of the colours of walls, exit, obstacles, floor and sky, drawn for \
                      each: the hue turns by this share of 180 degrees, and the brightness changes \
                      by this share",
        field: Field::Error(1.0, |reality| &mut reality.surfaces.color),
    },
    Row {
        name: "motion.turn_noise",
        description: "standard deviation of each turn, in degrees",
        field: Field::Number(180.0, |reality| &mut reality.motion.turn_noise),
    },
    Row {
        name: "motion.step_noise",
        description: "standard deviation of the length of each step, as a share of the length",
        field: Field::Number(1.0, |reality| &mut reality.motion.step_noise),
    },
    Row {
        name: "motion.turn_bias",
        description: "largest error of all turns of an episode, in degrees; each episode draws its \
                      error uniformly between -turn_bias and turn_bias",
        field: Field::Number(180.0, |reality| &mut reality.motion.turn_bias),
    },
    Row {
        name: "motion.step_bias",
        description: "largest error of the length of all steps of an episode, as a share of the \
                      length; each episode draws its error uniformly between -step_bias and \
                      step_bias",
        field: Field::Number(1.0, |reality| &mut reality.motion.step_bias),
    },
    Row {
        name: "odom.noise",
        description: "standard deviation of the odometry per metre and per radian moved; affects \
                      the topic odom, not the transform odom to base_link, which stays exact",
        field: Field::Number(1.0, |reality| &mut reality.odometry.noise),
    },
    Row {
        name: "odom.drift",
        description: "systematic error of the odometry as a share of distance and turn, with signs \
                      drawn for each episode; affects the topic odom",
        field: Field::Number(1.0, |reality| &mut reality.odometry.drift),
    },
    Row {
        name: "obstacles.speed_range",
        description: "factor of the step length of moving cylinders",
        field: Field::Factor(10.0, |reality| &mut reality.obstacles.speed),
    },
];

/// Declares the parameters and returns the perturbations that they describe.
///
/// # Errors
///
/// Returns an error if a value is invalid.
pub(super) fn declare(parameters: &Parameters) -> anyhow::Result<Reality> {
    let level = parameters.declare(
        RANDOMIZATION,
        Randomization::None.name().to_owned(),
        at_next_reset(
            "level of all perturbations (domain randomization): setting it sets camera.noise and \
             the other parameters of perturbations, unless the same request sets them",
        )
        .choices(Randomization::ALL.map(Randomization::name))
        .implies(|level| match level {
            ParameterValue::String(name) => name.parse().map(values_of).unwrap_or_default(),
            _ => Vec::new(),
        }),
    )?;
    let mut defaults = Reality::of(level.parse()?);
    for Row { name, description, field } in &ROWS {
        match field {
            Field::Number(maximum, of) => {
                let descriptor = at_next_reset(description).range(0.0..=*maximum);
                parameters.declare(name, *of(&mut defaults), descriptor)?;
            }
            Field::Error(maximum, of) => {
                let list = of(&mut defaults).to_list();
                declare_interval(
                    parameters,
                    (name, list),
                    &format!("{description}; [r] for -r to r, or [low, high]"),
                    (-maximum, *maximum),
                    |value| interval(value).map(drop),
                )?;
            }
            Field::Factor(maximum, of) => {
                let list = of(&mut defaults).to_list();
                declare_interval(
                    parameters,
                    (name, list),
                    &format!("{description}; [low, high]"),
                    (0.0, *maximum),
                    |value| match interval(value)?.low() {
                        low if low >= 0.0 => Ok(()),
                        low => Err(format!(
                            "a factor from {low} is negative (expected: [low, high], both at least \
                             0)"
                        )),
                    },
                )?;
            }
        }
    }
    parameters.declare(
        BLOCKED,
        defaults.motion.blocked.name().to_owned(),
        at_next_reset(
            "what a blocked move does. stay: position and heading do not change, as in the paper; \
             stop_short: the robot turns as far as it can and advances until it touches something; \
             mixed: one of the two, drawn for each episode",
        )
        .choices(BlockedMotion::ALL.map(BlockedMotion::name)),
    )?;
    read(parameters)
}

fn declare_interval(
    parameters: &Parameters,
    (name, default): (&str, Vec<f64>),
    description: &str,
    (low, high): (f64, f64),
    check: Check,
) -> Result<(), ParameterError> {
    let description = format!("{description}, from which each episode draws a value");
    let descriptor = at_next_reset(&description).range(low..=high).check(check);
    parameters.declare(name, default, descriptor).map(drop)
}

/// Returns the interval that a parameter describes. The value passed to a check always has the
/// declared type.
fn interval(value: &ParameterValue) -> Result<Interval, String> {
    let list = match value {
        ParameterValue::DoubleArray(list) => list.as_slice(),
        _ => &[],
    };
    Interval::from_list(list).map_err(|error| error.to_string())
}

/// Returns the perturbations that the parameters currently describe.
///
/// # Errors
///
/// Returns an error if a parameter is not declared.
pub(super) fn read(parameters: &Parameters) -> anyhow::Result<Reality> {
    let mut reality = Reality::default();
    for Row { name, field, .. } in &ROWS {
        match field {
            Field::Number(_, of) => {
                let value = parameters.get(name).with_context(|| name.to_string())?;
                *of(&mut reality) = value;
            }
            Field::Error(_, of) | Field::Factor(_, of) => {
                let list: Vec<f64> = parameters.get(name).with_context(|| name.to_string())?;
                *of(&mut reality) = Interval::from_list(&list)?;
            }
        }
    }
    let blocked: String = parameters.get(BLOCKED).context(BLOCKED)?;
    reality.motion.blocked = blocked.parse()?;
    Ok(reality)
}

/// Returns the values of all parameters at a level.
fn values_of(level: Randomization) -> Vec<(&'static str, ParameterValue)> {
    let mut reality = Reality::of(level);
    let mut values: Vec<_> = ROWS
        .iter()
        .map(|Row { name, field, .. }| match field {
            Field::Number(_, of) => (*name, ParameterValue::Double(*of(&mut reality))),
            Field::Error(_, of) | Field::Factor(_, of) => {
                (*name, ParameterValue::DoubleArray(of(&mut reality).to_list()))
            }
        })
        .collect();
    values.push((BLOCKED, ParameterValue::String(reality.motion.blocked.name().to_owned())));
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::parameters::tests::parameters;

    #[test]
    fn a_level_sets_all_perturbations() {
        assert_eq!(declare(&parameters("")).unwrap(), Reality::default());
        for level in Randomization::ALL {
            let expected = Reality::of(level);
            let line = format!("-p randomization:={level}");
            assert_eq!(declare(&parameters(&line)).unwrap(), expected);

            let parameters = parameters("-p randomization:=strong");
            declare(&parameters).unwrap();
            parameters.set(RANDOMIZATION, ParameterValue::String(level.to_string())).unwrap();
            assert_eq!(read(&parameters).unwrap(), expected);
        }
    }

    #[test]
    fn single_parameters_override_the_level() {
        let line = "-p camera.noise:=5 -p randomization:=mild -p camera.gain_range:=[0.5,0.75]";
        let reality = declare(&parameters(line)).unwrap();
        let mut expected = Reality::of(Randomization::Mild);
        (expected.camera.noise, expected.camera.gain) = (5.0, Interval::between(0.5, 0.75));
        assert_eq!(reality, expected);
    }

    #[test]
    fn errors_state_what_is_valid() {
        for (line, expected) in [
            ("camera.noise:=-1", "parameter 'camera.noise' is the number -1: expected 0 to 255"),
            (
                "camera.gain_range:=[2.0,1.0]",
                "parameter 'camera.gain_range' is the list [2.0, 1.0]: invalid limits 2 and 1 \
                 (expected: finite numbers, the lower limit first)",
            ),
            (
                "camera.yaw_range:=[1.0,2.0,3.0]",
                "parameter 'camera.yaw_range' is the list [1.0, 2.0, 3.0]: invalid length 3 \
                 (expected: [r] for -r to r, or [low, high])",
            ),
            (
                "camera.gain_range:=[0.5]",
                "parameter 'camera.gain_range' is the list [0.5]: a factor from -0.5 is negative \
                 (expected: [low, high], both at least 0)",
            ),
            (
                "motion.blocked:=jump",
                "parameter 'motion.blocked' is the string 'jump': expected one of stay, \
                 stop_short, mixed",
            ),
        ] {
            let error = declare(&parameters(&format!("-p {line}"))).unwrap_err();
            assert_eq!(error.to_string(), expected);
        }
    }
}
