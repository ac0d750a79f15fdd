//! All that a robot must not touch.

use super::concave_wall::ConcaveWall;
use super::cylinder::Cylinder;
use super::robot::Footprint;
use super::room::Wall;

/// What blocks a move: the walls, and the obstacles of the scenario.
#[derive(Debug, Clone, Copy)]
pub(super) struct Obstacles<'world> {
    /// The cylinders, standing or moving.
    pub(super) cylinders: &'world [Cylinder],
    /// The concave wall, where the scenario has it.
    pub(super) concave_wall: Option<&'world ConcaveWall>,
}

impl Obstacles<'_> {
    /// Whether the footprint reaches a wall or an obstacle.
    pub(super) fn touch(&self, footprint: &Footprint) -> bool {
        Wall::ALL.iter().any(|wall| wall.touches(footprint))
            || self.cylinders.iter().any(|cylinder| cylinder.touches(footprint))
            || self.concave_wall.is_some_and(|wall| wall.touches(footprint))
    }
}
