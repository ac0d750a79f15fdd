//! What of a layout is held fixed, for figures and experiments.

use nalgebra::{Isometry2, Point2, Vector2};

use super::exit::{Exit, ExitOffWall};
use super::room::Wall;

/// The parts of a layout that every reset puts in the same place; `None` is random.
///
/// What is fixed has to keep the same rules as what is random: [`super::World::new`] and
/// [`super::World::reset`] check it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Layout {
    /// The exit.
    pub exit: Option<Exit>,
    /// The cylinders' centres, as many as the scenario has cylinders. Those that move start here.
    pub cylinders: Option<Vec<Point2<f64>>>,
    /// The pose in which the robot starts.
    pub robot: Option<Isometry2<f64>>,
}

/// Why lists of numbers do not say what is fixed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LayoutError {
    /// `fixed_exit` is not a pair.
    #[error("fixed_exit has {0} numbers: it is [wall, offset], or empty for a random exit")]
    ExitLength(usize),
    /// `fixed_exit` names no wall.
    #[error("fixed_exit is on wall {0}: a wall is 0 (+x), 1 (+y), 2 (-x) or 3 (-y)")]
    UnknownWall(f64),
    /// `fixed_exit` is not wholly on its wall.
    #[error("fixed_exit: {0}")]
    ExitOffWall(#[from] ExitOffWall),
    /// `fixed_cylinders` are not pairs.
    #[error(
        "fixed_cylinders has {0} numbers: it is [x, y, ...], two for each cylinder, or empty for \
         random places"
    )]
    CylindersLength(usize),
    /// `fixed_robot` is not a pose.
    #[error("fixed_robot has {0} numbers: it is [x, y, yaw], or empty for a random pose")]
    RobotLength(usize),
    /// A number is infinite or not a number.
    #[error("{parameter} contains {number}: all its numbers are finite")]
    NotFinite {
        /// The parameter.
        parameter: &'static str,
        /// The number.
        number: f64,
    },
}

impl Layout {
    /// The layout that three lists of numbers describe, as the parameters of the same names give
    /// them; an empty list leaves its part random.
    ///
    /// - `fixed_exit`: `[wall, offset]`, the wall 0..=3 for +x, +y, -x, -y, and the exit's distance
    ///   from its middle in metres, as in [`Exit::new`];
    /// - `fixed_cylinders`: `[x, y, ...]` in metres;
    /// - `fixed_robot`: `[x, y, yaw]` in metres and radians.
    pub fn from_parameters(
        fixed_exit: &[f64],
        fixed_cylinders: &[f64],
        fixed_robot: &[f64],
    ) -> Result<Self, LayoutError> {
        all_finite("fixed_exit", fixed_exit)?;
        all_finite("fixed_cylinders", fixed_cylinders)?;
        all_finite("fixed_robot", fixed_robot)?;
        let exit = match *fixed_exit {
            [] => None,
            [wall, offset] => Some(Exit::new(numbered_wall(wall)?, offset)?),
            _ => return Err(LayoutError::ExitLength(fixed_exit.len())),
        };
        let cylinders = match fixed_cylinders.as_chunks() {
            ([], []) => None,
            (pairs, []) => Some(pairs.iter().map(|&[x, y]| Point2::new(x, y)).collect()),
            _ => return Err(LayoutError::CylindersLength(fixed_cylinders.len())),
        };
        let robot = match *fixed_robot {
            [] => None,
            [x, y, yaw] => Some(Isometry2::new(Vector2::new(x, y), yaw)),
            _ => return Err(LayoutError::RobotLength(fixed_robot.len())),
        };
        Ok(Self { exit, cylinders, robot })
    }
}

fn all_finite(parameter: &'static str, numbers: &[f64]) -> Result<(), LayoutError> {
    match numbers.iter().find(|number| !number.is_finite()) {
        Some(&number) => Err(LayoutError::NotFinite { parameter, number }),
        None => Ok(()),
    }
}

fn numbered_wall(number: f64) -> Result<Wall, LayoutError> {
    (0..)
        .map(f64::from)
        .zip(Wall::ALL)
        .find(|&(index, _)| index == number)
        .map_or(Err(LayoutError::UnknownWall(number)), |(_, wall)| Ok(wall))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_lists_leave_everything_random() {
        assert_eq!(Layout::from_parameters(&[], &[], &[]), Ok(Layout::default()));
    }

    #[test]
    fn lists_say_what_is_fixed() {
        let layout =
            Layout::from_parameters(&[3.0, -0.5], &[0.1, 0.2, -0.3, -0.4], &[1.0, 0.5, 0.25]);
        assert_eq!(
            layout,
            Ok(Layout {
                exit: Exit::new(Wall::NegativeY, -0.5).ok(),
                cylinders: Some(vec![Point2::new(0.1, 0.2), Point2::new(-0.3, -0.4)]),
                robot: Some(Isometry2::new(Vector2::new(1.0, 0.5), 0.25)),
            })
        );
    }

    #[test]
    fn a_wrong_list_is_answered_with_the_right_form() {
        for (exit, cylinders, robot, message) in [
            (
                &[1.0][..],
                &[][..],
                &[][..],
                "fixed_exit has 1 numbers: it is [wall, offset], or empty for a random exit",
            ),
            (
                &[0.5, 0.0],
                &[],
                &[],
                "fixed_exit is on wall 0.5: a wall is 0 (+x), 1 (+y), 2 (-x) or 3 (-y)",
            ),
            (
                &[2.0, -1.25],
                &[],
                &[],
                "fixed_exit: an exit -1.25 m from the middle of the -x wall is not wholly on it: \
                 the offset is within ±1 m",
            ),
            (
                &[],
                &[0.0, 0.5, 0.5],
                &[],
                "fixed_cylinders has 3 numbers: it is [x, y, ...], two for each cylinder, or \
                 empty for random places",
            ),
            (
                &[],
                &[],
                &[0.0, 0.5],
                "fixed_robot has 2 numbers: it is [x, y, yaw], or empty for a random pose",
            ),
            (
                &[],
                &[],
                &[0.0, 0.5, f64::INFINITY],
                "fixed_robot contains inf: all its numbers are finite",
            ),
        ] {
            let error = Layout::from_parameters(exit, cylinders, robot).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
    }
}
