//! Where everything is at the start of an episode.

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

/// How many random layouts are tried. With nothing fixed, at least one in a few hundred keeps
/// every rule.
const ATTEMPTS: u32 = 100_000;

/// Why nothing can be placed. Only what is held fixed ([`Layout`]) can lead to it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlacementError {
    /// As many cylinders are fixed as another scenario has.
    #[error("scenario `{scenario}` has {expected} cylinders, but {given} are held fixed")]
    CylinderCount {
        /// The scenario.
        scenario: Scenario,
        /// How many cylinders it has.
        expected: usize,
        /// How many were given.
        given: usize,
    },
    /// A cylinder is too close to a wall.
    #[error(
        "the cylinder at ({x}, {y}) m is outside the central square: x and y are within \
         ±{half_square} m"
    )]
    CylinderOutside {
        /// The x of its centre.
        x: f64,
        /// The y of its centre.
        y: f64,
        /// The furthest from 0 that both may be.
        half_square: f64,
    },
    /// Two cylinders are too close to each other.
    #[error(
        "the cylinders at ({}, {}) m and ({}, {}) m are {distance:.4} m apart: at least {least} m \
         is needed", first[0], first[1], second[0], second[1]
    )]
    CylindersTooClose {
        /// The centre of one.
        first: [f64; 2],
        /// The centre of the other.
        second: [f64; 2],
        /// Between the centres.
        distance: f64,
        /// What is needed.
        least: f64,
    },
    /// A standing cylinder is too close to where the robot starts.
    #[error(
        "the robot at ({}, {}) m is {distance:.4} m from the cylinder at ({}, {}) m: at least \
         {least} m is needed", robot[0], robot[1], cylinder[0], cylinder[1]
    )]
    RobotTooClose {
        /// The robot's centre.
        robot: [f64; 2],
        /// The cylinder's centre.
        cylinder: [f64; 2],
        /// Between the centres.
        distance: f64,
        /// What is needed.
        least: f64,
    },
    /// The robot starts in touch with something.
    #[error("the robot at ({x}, {y}) m with yaw {yaw} touches {what}: it starts touching nothing")]
    RobotTouches {
        /// The x of its centre.
        x: f64,
        /// The y of its centre.
        y: f64,
        /// Its heading, in radians.
        yaw: f64,
        /// What it touches.
        what: &'static str,
    },
    /// What is fixed leaves no room for the rest.
    #[error(
        "no room in scenario `{scenario}`: what is fixed left no place for the rest in {ATTEMPTS} \
         random layouts (the last: {last}); free or move the exit, the cylinders or the robot"
    )]
    NoRoom {
        /// The scenario.
        scenario: Scenario,
        /// What was wrong with the last layout tried.
        last: Box<PlacementError>,
    },
}

/// A layout that keeps every rule.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placement {
    pub(super) exit: Exit,
    pub(super) cylinders: Vec<Cylinder>,
    pub(super) robot: Isometry2<f64>,
}

/// The rules of placement in a scenario.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules<'world> {
    scenario: Scenario,
    spacing: Spacing,
    concave_wall: Option<&'world ConcaveWall>,
}

impl<'world> Rules<'world> {
    pub(super) fn new(scenario: Scenario, concave_wall: &'world ConcaveWall) -> Self {
        let spacing = if scenario.moving() { Spacing::MOVING } else { Spacing::STANDING };
        Self { scenario, spacing, concave_wall: scenario.concave().then_some(concave_wall) }
    }

    /// Draws what `layout` leaves free: first the exit, uniform over the walls and along them; then
    /// cylinders and robot together until every rule holds, which makes them uniform over all
    /// that fits.
    ///
    /// Cylinders that are `kept` from the episode before stay where they are, unless they are in
    /// the way of a fixed robot.
    pub(super) fn place(
        &self,
        layout: &Layout,
        kept: Option<Vec<Cylinder>>,
        random: &mut Random,
    ) -> Result<Placement, PlacementError> {
        let robot = layout.robot.as_ref();
        let kept = kept.filter(|cylinders| self.check(None, cylinders, robot).is_ok());
        let known = match &kept {
            Some(cylinders) => Some(cylinders.clone()),
            None => self.fixed_cylinders(layout)?,
        };
        // Whatever is wrong with the fixed parts alone is said before anything is drawn.
        self.check(layout.exit.as_ref(), known.as_deref().unwrap_or_default(), robot)?;

        let exit = self.draw_until(
            || layout.exit.unwrap_or_else(|| random_exit(random)),
            |exit| self.check(Some(exit), &[], robot),
        )?;
        let (mut cylinders, robot) = self.draw_until(
            || {
                let cylinders = known.clone().unwrap_or_else(|| self.random_cylinders(random));
                (cylinders, layout.robot.unwrap_or_else(|| random_robot(random)))
            },
            |(cylinders, robot)| self.check(Some(&exit), cylinders, Some(robot)),
        )?;
        if self.scenario.moving() && kept.is_none() {
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
        Ok(Some(centres.iter().copied().map(Cylinder::standing).collect()))
    }

    fn random_cylinders(&self, random: &mut Random) -> Vec<Cylinder> {
        let half = self.spacing.half_square;
        (0..self.scenario.cylinders())
            .map(|_| Cylinder::standing(Point2::new(random.within(half), random.within(half))))
            .collect()
    }

    /// The first draw that passes the check.
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
                    return Err(PlacementError::NoRoom {
                        scenario: self.scenario,
                        last: Box::new(last),
                    });
                }
                Err(_) => attempts += 1,
            }
        }
    }

    /// Whether the parts of a layout that are already known keep the rules among themselves.
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
                        least: self.spacing.apart,
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
                    least: self.spacing.from_robot,
                });
            }
        }
        let footprint = Footprint::at(robot);
        let what = if Wall::ALL.iter().any(|wall| wall.touches(&footprint)) {
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
        Err(PlacementError::RobotTouches { x: robot_centre.x, y: robot_centre.y, yaw, what })
    }
}

fn random_exit(random: &mut Random) -> Exit {
    let wall = Wall::ALL[random.below(Wall::ALL.len())];
    Exit::new(wall, random.within(EXIT_REACH)).expect("the offset was drawn within the reach")
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
    fn gives_up_where_nothing_fits() {
        let concave_wall = ConcaveWall::new();
        let rules = Rules::new(Scenario::OneMoving, &concave_wall);
        let mut draws = 0;
        let outside = PlacementError::CylinderOutside { x: 0.9, y: 0.0, half_square: 0.75 };
        let error = rules.draw_until(|| draws += 1, |_| Err(outside.clone())).unwrap_err();
        assert_eq!(draws, ATTEMPTS);
        assert_eq!(
            error.to_string(),
            "no room in scenario `one_moving`: what is fixed left no place for the rest in 100000 \
             random layouts (the last: the cylinder at (0.9, 0) m is outside the central square: x \
             and y are within ±0.75 m); free or move the exit, the cylinders or the robot"
        );
    }
}
