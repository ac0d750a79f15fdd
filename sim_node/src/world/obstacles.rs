//! Everything that blocks the robot.

use super::concave_wall::ConcaveWall;
use super::cylinder::Cylinder;
use super::robot::Footprint;
use super::room::Wall;

/// The walls and the obstacles of the scenario, which block moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Obstacles<'world> {
    /// The cylinders, static or moving.
    pub(super) cylinders: &'world [Cylinder],
    /// The concave wall; `None` in scenarios without it.
    pub(super) concave_wall: Option<&'world ConcaveWall>,
}

impl Obstacles<'_> {
    /// Returns whether the footprint touches a wall or an obstacle.
    pub(super) fn touch(&self, footprint: &Footprint) -> bool {
        Wall::ALL.iter().any(|wall| wall.touches(footprint))
            || self.cylinders.iter().any(|cylinder| cylinder.touches(footprint))
            || self.concave_wall.is_some_and(|wall| wall.touches(footprint))
    }
}
