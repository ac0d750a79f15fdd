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
    /// The exit is not a pair.
    #[error("the fixed exit has {0} numbers: it is [wall, offset], or empty for a random exit")]
    ExitLength(usize),
    /// The exit names no wall.
    #[error("the fixed exit is on wall {0}: a wall is 0 (+x), 1 (+y), 2 (-x) or 3 (-y)")]
    UnknownWall(f64),
    /// The exit is not wholly on its wall.
    #[error("the fixed exit: {0}")]
    ExitOffWall(#[from] ExitOffWall),
    /// The cylinders are not pairs.
    #[error(
        "the fixed cylinders' list has {0} numbers: it is [x, y, ...], two for each cylinder, or empty for \
         random places"
    )]
    CylindersLength(usize),
    /// The robot is not a pose.
    #[error(
        "the fixed robot's pose has {0} numbers: it is [x, y, yaw], or empty for a random pose"
    )]
    RobotLength(usize),
    /// A number is infinite or not a number.
    #[error("{what} contains {number}: all its numbers are finite")]
    NotFinite {
        /// Of what.
        what: &'static str,
        /// The number.
        number: f64,
    },
}

impl Layout {
    /// The layout that three lists of numbers describe; an empty list leaves its part random.
    ///
    /// - the exit: `[wall, offset]`, the wall 0..=3 for +x, +y, -x, -y, and the exit's distance
    ///   from its middle in metres, as in [`Exit::new`];
    /// - the cylinders: `[x, y, ...]` in metres;
    /// - the robot: `[x, y, yaw]` in metres and radians.
    pub fn from_lists(exit: &[f64], cylinders: &[f64], robot: &[f64]) -> Result<Self, LayoutError> {
        all_finite("the fixed exit", exit)?;
        all_finite("the fixed cylinders' list", cylinders)?;
        all_finite("the fixed robot's pose", robot)?;
        let exit = match *exit {
            [] => None,
            [wall, offset] => Some(Exit::new(numbered_wall(wall)?, offset)?),
            _ => return Err(LayoutError::ExitLength(exit.len())),
        };
        let cylinders = match cylinders.as_chunks() {
            ([], []) => None,
            (pairs, []) => Some(pairs.iter().map(|&[x, y]| Point2::new(x, y)).collect()),
            _ => return Err(LayoutError::CylindersLength(cylinders.len())),
        };
        let robot = match *robot {
            [] => None,
            [x, y, yaw] => Some(Isometry2::new(Vector2::new(x, y), yaw)),
            _ => return Err(LayoutError::RobotLength(robot.len())),
        };
        Ok(Self { exit, cylinders, robot })
    }
}

fn all_finite(what: &'static str, numbers: &[f64]) -> Result<(), LayoutError> {
    match numbers.iter().find(|number| !number.is_finite()) {
        Some(&number) => Err(LayoutError::NotFinite { what, number }),
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
        assert_eq!(Layout::from_lists(&[], &[], &[]), Ok(Layout::default()));
    }

    #[test]
    fn lists_say_what_is_fixed() {
        let layout = Layout::from_lists(&[3.0, -0.5], &[0.1, 0.2, -0.3, -0.4], &[1.0, 0.5, 0.25]);
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
                "the fixed exit has 1 numbers: it is [wall, offset], or empty for a random exit",
            ),
            (
                &[0.5, 0.0],
                &[],
                &[],
                "the fixed exit is on wall 0.5: a wall is 0 (+x), 1 (+y), 2 (-x) or 3 (-y)",
            ),
            (
                &[2.0, -1.25],
                &[],
                &[],
                "the fixed exit: an exit -1.25 m from the middle of the -x wall is not wholly on it: \
                 the offset is within ±1 m",
            ),
            (
                &[],
                &[0.0, 0.5, 0.5],
                &[],
                "the fixed cylinders' list has 3 numbers: it is [x, y, ...], two for each cylinder, or \
                 empty for random places",
            ),
            (
                &[],
                &[],
                &[0.0, 0.5],
                "the fixed robot's pose has 2 numbers: it is [x, y, yaw], or empty for a random pose",
            ),
            (
                &[],
                &[],
                &[0.0, 0.5, f64::INFINITY],
                "the fixed robot's pose contains inf: all its numbers are finite",
            ),
        ] {
            let error = Layout::from_lists(exit, cylinders, robot).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
    }
}
