//! Layouts at the start of an episode and their placement rules.

use std::f64::consts::PI;

use nalgebra::{Isometry2, Point2, UnitComplex, Vector2, distance};
use task::{Random, Scenario};

use super::concave_wall::ConcaveWall;
use super::cylinder::Cylinder;
use super::exit::{EXIT_REACH, Exit};
use super::layout::Layout;
use super::robot::Footprint;
use super::room::{ROOM_SIDE, Wall};
use super::spacing::Spacing;

/// Maximum number of random layouts to try. Without fixed parts, at least one in a few hundred
/// follows all rules.
const ATTEMPTS: u32 = 100_000;

/// The error for a layout that violates a rule or cannot be completed. Only fixed parts
/// ([`Layout`]) can cause it.
///
/// Positions and distances are in metres.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlacementError {
    /// The number of fixed cylinders differs from that in the scenario.
    #[error("fixed cylinders: found {given} (expected: {expected} in scenario {scenario})")]
    CylinderCount {
        /// The scenario.
        scenario: Scenario,
        /// Number of cylinders in the scenario.
        expected: usize,
        /// Number of fixed cylinders.
        given: usize,
    },
    /// A cylinder is outside the central square.
    #[error(
        "cylinder at ({x}, {y}) m: outside the central square (expected: x and y within \
         ±{half_square} m)"
    )]
    CylinderOutside {
        /// The x coordinate of its centre.
        x: f64,
        /// The y coordinate of its centre.
        y: f64,
        /// Maximum absolute value of both coordinates.
        half_square: f64,
    },
    /// Two cylinders are too close to each other.
    #[error(
        "cylinders at ({}, {}) m and ({}, {}) m: distance {distance:.4} m (expected: at least \
         {minimum} m)", first[0], first[1], second[0], second[1]
    )]
    CylindersTooClose {
        /// Centre `[x, y]` of the first cylinder.
        first: [f64; 2],
        /// Centre `[x, y]` of the second cylinder.
        second: [f64; 2],
        /// Distance between the centres.
        distance: f64,
        /// Minimum distance.
        minimum: f64,
    },
    /// A static cylinder is too close to the robot.
    #[error(
        "robot at ({}, {}) m and cylinder at ({}, {}) m: distance {distance:.4} m (expected: at \
         least {minimum} m)", robot[0], robot[1], cylinder[0], cylinder[1]
    )]
    RobotTooClose {
        /// Centre `[x, y]` of the robot.
        robot: [f64; 2],
        /// Centre `[x, y]` of the cylinder.
        cylinder: [f64; 2],
        /// Distance between the centres.
        distance: f64,
        /// Minimum distance.
        minimum: f64,
    },
    /// The robot touches an object at its start pose.
    #[error(
        "robot at ({x}, {y}) m with yaw {yaw} rad: touches {object} (expected: a collision-free \
         start pose)"
    )]
    RobotTouches {
        /// The x coordinate of its centre.
        x: f64,
        /// The y coordinate of its centre.
        y: f64,
        /// Its heading in radians.
        yaw: f64,
        /// The object that it touches.
        object: &'static str,
    },
    /// The fixed parts leave no space for the random ones.
    #[error(
        "scenario {scenario}: the fixed parts of the layout rule out all {ATTEMPTS} random layouts \
         (the last: {last}); move the fixed exit, cylinders or robot, or make them random"
    )]
    NoSpace {
        /// The scenario.
        scenario: Scenario,
        /// The violation in the last layout that was tried.
        last: Box<PlacementError>,
    },
}

/// A layout that follows all rules.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placement {
    pub(super) exit: Exit,
    pub(super) cylinders: Vec<Cylinder>,
    pub(super) robot: Isometry2<f64>,
}

/// The placement rules of a scenario.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules<'world> {
    scenario: Scenario,
    spacing: Spacing,
    concave_wall: Option<&'world ConcaveWall>,
}

impl<'world> Rules<'world> {
    pub(super) fn new(scenario: Scenario, concave_wall: &'world ConcaveWall) -> Self {
        let spacing =
            if scenario.has_moving_obstacles() { Spacing::MOVING } else { Spacing::STATIC };
        let concave_wall = scenario.has_concave_wall().then_some(concave_wall);
        Self { scenario, spacing, concave_wall }
    }

    /// Draws the random parts of `layout`.
    ///
    /// The exit is drawn first, uniformly over the walls and along the wall. The cylinders and the
    /// robot are then drawn together until they follow all rules, so that they are uniform over all
    /// valid placements.
    ///
    /// `kept` contains the moving cylinders of the previous episode. They keep their poses unless
    /// they are in the way of a fixed robot.
    ///
    /// # Errors
    ///
    /// Returns an error if the fixed parts violate a rule or leave no space for the random parts.
    pub(super) fn place(
        &self,
        layout: &Layout,
        kept: Option<Vec<Cylinder>>,
        random: &mut Random,
    ) -> Result<Placement, PlacementError> {
        let robot = layout.robot.as_ref();
        let kept = kept.filter(|cylinders| self.check(None, cylinders, robot).is_ok());
        let given = match &kept {
            Some(cylinders) => Some(cylinders.clone()),
            None => self.fixed_cylinders(layout)?,
        };
        // Reports a violation among the fixed parts before drawing the others.
        self.check(layout.exit.as_ref(), given.as_deref().unwrap_or_default(), robot)?;

        let exit = self.draw_until(
            || layout.exit.unwrap_or_else(|| random_exit(random)),
            |exit| self.check(Some(exit), &[], robot),
        )?;
        let (mut cylinders, robot) = self.draw_until(
            || {
                let cylinders = given.clone().unwrap_or_else(|| self.random_cylinders(random));
                (cylinders, layout.robot.unwrap_or_else(|| random_robot(random)))
            },
            |(cylinders, robot)| self.check(Some(&exit), cylinders, Some(robot)),
        )?;
        if self.scenario.has_moving_obstacles() && kept.is_none() {
            for cylinder in &mut cylinders {
                cylinder.pose.rotation = UnitComplex::new(random.within(PI));
            }
        }
        Ok(Placement { exit, cylinders, robot })
    }

    fn fixed_cylinders(&self, layout: &Layout) -> Result<Option<Vec<Cylinder>>, PlacementError> {
        let Some(centres) = &layout.cylinders else { return Ok(None) };
        let (scenario, expected, given) = (self.scenario, self.scenario.cylinders(), centres.len());
        if given != expected {
            return Err(PlacementError::CylinderCount { scenario, expected, given });
        }
        Ok(Some(centres.iter().copied().map(Cylinder::new).collect()))
    }

    fn random_cylinders(&self, random: &mut Random) -> Vec<Cylinder> {
        let half = self.spacing.half_square;
        (0..self.scenario.cylinders())
            .map(|_| Cylinder::new(Point2::new(random.within(half), random.within(half))))
            .collect()
    }

    /// Returns the first draw that passes the check, or an error after [`ATTEMPTS`] draws.
    fn draw_until<T>(
        &self,
        mut draw: impl FnMut() -> T,
        check: impl Fn(&T) -> Result<(), PlacementError>,
    ) -> Result<T, PlacementError> {
        let mut attempts = 1;
        loop {
            let drawn = draw();
            match check(&drawn) {
                Ok(()) => return Ok(drawn),
                Err(last) if attempts == ATTEMPTS => {
                    return Err(PlacementError::NoSpace {
                        scenario: self.scenario,
                        last: Box::new(last),
                    });
                }
                Err(_) => attempts += 1,
            }
        }
    }

    /// Checks the rules for the given parts of a layout.
    fn check(
        &self,
        exit: Option<&Exit>,
        cylinders: &[Cylinder],
        robot: Option<&Isometry2<f64>>,
    ) -> Result<(), PlacementError> {
        self.check_cylinders(cylinders)?;
        match robot {
            Some(robot) => self.check_robot(robot, exit, cylinders),
            None => Ok(()),
        }
    }

    fn check_cylinders(&self, cylinders: &[Cylinder]) -> Result<(), PlacementError> {
        for (index, cylinder) in cylinders.iter().enumerate() {
            let centre = cylinder.centre();
            if !self.spacing.contains(&centre) {
                let half_square = self.spacing.half_square;
                return Err(PlacementError::CylinderOutside {
                    x: centre.x,
                    y: centre.y,
                    half_square,
                });
            }
            for other in cylinders[..index].iter().map(Cylinder::centre) {
                if !self.spacing.separates(&other, &centre) {
                    return Err(PlacementError::CylindersTooClose {
                        first: other.into(),
                        second: centre.into(),
                        distance: distance(&other, &centre),
                        minimum: self.spacing.apart,
                    });
                }
            }
        }
        Ok(())
    }

    fn check_robot(
        &self,
        robot: &Isometry2<f64>,
        exit: Option<&Exit>,
        cylinders: &[Cylinder],
    ) -> Result<(), PlacementError> {
        let robot_centre = Point2::from(robot.translation.vector);
        for centre in cylinders.iter().map(Cylinder::centre) {
            let distance = distance(&robot_centre, &centre);
            if distance < self.spacing.from_robot {
                return Err(PlacementError::RobotTooClose {
                    robot: robot_centre.into(),
                    cylinder: centre.into(),
                    distance,
                    minimum: self.spacing.from_robot,
                });
            }
        }
        let footprint = Footprint::at(robot);
        let object = if Wall::ALL.iter().any(|wall| wall.touches(&footprint)) {
            "a wall"
        } else if exit.is_some_and(|exit| exit.touches(&footprint)) {
            "the exit"
        } else if cylinders.iter().any(|cylinder| cylinder.touches(&footprint)) {
            "a cylinder"
        } else if self.concave_wall.is_some_and(|wall| wall.touches(&footprint)) {
            "the concave wall"
        } else {
            return Ok(());
        };
        let yaw = robot.rotation.angle();
        Err(PlacementError::RobotTouches { x: robot_centre.x, y: robot_centre.y, yaw, object })
    }
}

fn random_exit(random: &mut Random) -> Exit {
    let wall = Wall::ALL[random.below(Wall::ALL.len())];
    Exit::new(wall, random.within(EXIT_REACH)).expect("the offset is within EXIT_REACH")
}

fn random_robot(random: &mut Random) -> Isometry2<f64> {
    let half = ROOM_SIDE / 2.0;
    let centre = Vector2::new(random.within(half), random.within(half));
    Isometry2::new(centre, random.within(PI))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gives_up_after_a_limited_number_of_attempts() {
        let concave_wall = ConcaveWall::new();
        let rules = Rules::new(Scenario::OneMoving, &concave_wall);
        let mut draws = 0;
        let outside = PlacementError::CylinderOutside { x: 0.9, y: 0.0, half_square: 0.75 };
        let error = rules.draw_until(|| draws += 1, |_| Err(outside.clone())).unwrap_err();
        assert_eq!(draws, ATTEMPTS);
        assert_eq!(
            error.to_string(),
            "scenario one_moving: the fixed parts of the layout rule out all 100000 random layouts \
             (the last: cylinder at (0.9, 0) m: outside the central square (expected: x and y \
             within ±0.75 m)); move the fixed exit, cylinders or robot, or make them random"
        );
    }
}
