//! Fixed layouts, for figures and experiments.

use nalgebra::{Isometry2, Point2, Vector2};

use super::exit::{Exit, ExitOffWall};
use super::room::Wall;

/// The fixed parts of the layout; every reset draws the parts that are `None` at random.
///
/// Fixed parts must follow the same placement rules as random ones. [`super::World::new`] and
/// [`super::World::reset`] check this.
///
/// # Examples
///
/// ```
/// use sim_node::world::{Layout, Wall};
///
/// // The exit is 0.5 m from the middle of the +y wall; the robot faces it.
/// let layout = Layout::from_lists(&[1.0, 0.5], &[], &[0.5, 0.0, 1.5708])?;
/// assert_eq!(layout.exit.map(|exit| exit.wall()), Some(Wall::PositiveY));
/// assert_eq!(layout.cylinders, None);
/// # Ok::<(), sim_node::world::LayoutError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Layout {
    /// The exit.
    pub exit: Option<Exit>,
    /// Centres of the cylinders in metres, one per cylinder of the scenario. Moving cylinders start
    /// there.
    pub cylinders: Option<Vec<Point2<f64>>>,
    /// Start pose of the robot's centre, in metres and radians.
    pub robot: Option<Isometry2<f64>>,
}

/// The error for lists of numbers that do not describe a layout.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LayoutError {
    /// The exit list has an invalid length. Holds the length.
    #[error(
        "fixed exit: invalid length {0} (expected: [wall, offset], or empty for a random exit)"
    )]
    ExitLength(usize),
    /// The wall is unknown. Holds its number.
    #[error("fixed exit: unknown wall {0} (expected: 0 for +x, 1 for +y, 2 for -x, 3 for -y)")]
    UnknownWall(f64),
    /// The exit is not entirely on its wall.
    #[error("fixed {0}")]
    ExitOffWall(#[from] ExitOffWall),
    /// The cylinder list has an odd length. Holds the length.
    #[error(
        "fixed cylinders: invalid length {0} (expected: [x, y, ...], two per cylinder, or empty \
         for random positions)"
    )]
    CylindersLength(usize),
    /// The robot list has an invalid length. Holds the length.
    #[error("fixed robot: invalid length {0} (expected: [x, y, yaw], or empty for a random pose)")]
    RobotLength(usize),
    /// A number is infinite or NaN.
    #[error("{list}: invalid number {number} (expected: finite numbers)")]
    NotFinite {
        /// Name of the list.
        list: &'static str,
        /// The invalid number.
        number: f64,
    },
}

impl Layout {
    /// Parses three lists of numbers; an empty list leaves its part random.
    ///
    /// - `exit`: `[wall, offset]`, with the wall 0..=3 for +x, +y, -x, -y, and the offset from the
    ///   middle of the wall in metres, as in [`Exit::new`];
    /// - `cylinders`: `[x, y, ...]` in metres, two numbers per cylinder;
    /// - `robot`: `[x, y, yaw]` in metres and radians.
    ///
    /// # Errors
    ///
    /// Returns an error if a list has an invalid length or contains a number that is not finite, if
    /// the wall is unknown, or if the exit is not entirely on its wall.
    pub fn from_lists(exit: &[f64], cylinders: &[f64], robot: &[f64]) -> Result<Self, LayoutError> {
        check_finite("fixed exit", exit)?;
        check_finite("fixed cylinders", cylinders)?;
        check_finite("fixed robot", robot)?;
        let exit = match *exit {
            [] => None,
            [wall, offset] => Some(Exit::new(wall_of_number(wall)?, offset)?),
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

fn check_finite(list: &'static str, numbers: &[f64]) -> Result<(), LayoutError> {
    match numbers.iter().find(|number| !number.is_finite()) {
        Some(&number) => Err(LayoutError::NotFinite { list, number }),
        None => Ok(()),
    }
}

fn wall_of_number(number: f64) -> Result<Wall, LayoutError> {
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
    fn empty_lists_give_a_random_layout() {
        assert_eq!(Layout::from_lists(&[], &[], &[]), Ok(Layout::default()));
    }

    #[test]
    fn lists_give_a_fixed_layout() {
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
    fn errors_for_invalid_lists_state_the_expected_format() {
        for (exit, cylinders, robot, message) in [
            (
                &[1.0][..],
                &[][..],
                &[][..],
                "fixed exit: invalid length 1 (expected: [wall, offset], or empty for a random \
                 exit)",
            ),
            (
                &[0.5, 0.0],
                &[],
                &[],
                "fixed exit: unknown wall 0.5 (expected: 0 for +x, 1 for +y, 2 for -x, 3 for -y)",
            ),
            (
                &[2.0, -1.25],
                &[],
                &[],
                "fixed exit offset: -1.25 m from the middle of the -x wall is out of range \
                 (expected: within ±1 m)",
            ),
            (
                &[],
                &[0.0, 0.5, 0.5],
                &[],
                "fixed cylinders: invalid length 3 (expected: [x, y, ...], two per cylinder, or \
                 empty for random positions)",
            ),
            (
                &[],
                &[],
                &[0.0, 0.5],
                "fixed robot: invalid length 2 (expected: [x, y, yaw], or empty for a random pose)",
            ),
            (
                &[],
                &[],
                &[0.0, 0.5, f64::INFINITY],
                "fixed robot: invalid number inf (expected: finite numbers)",
            ),
        ] {
            let error = Layout::from_lists(exit, cylinders, robot).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
    }
}
