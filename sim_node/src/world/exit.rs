//! The exit: a box, half in a wall and half in the room.

use nalgebra::Isometry2;
use parry2d::math::Vector;
use parry2d::shape::Cuboid;

use super::contact;
use super::robot::Footprint;
use super::room::{ROOM_SIDE, Wall};

/// Width of the exit along its wall, in metres.
pub const EXIT_WIDTH: f64 = 0.5;

/// Depth of the exit across its wall, in metres. Half of it is in the room.
pub const EXIT_DEPTH: f64 = 0.2;

/// Height of the exit in metres.
pub const EXIT_HEIGHT: f64 = 1.0;

/// Maximum distance of the exit's centre from the middle of its wall, in metres. Within this
/// distance, the whole exit is on the wall.
pub const EXIT_REACH: f64 = (ROOM_SIDE - EXIT_WIDTH) / 2.0;

/// The position of the exit: entirely on one of the walls, by construction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exit {
    wall: Wall,
    offset: f64,
}

/// The error for an exit that is not entirely on its wall.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "exit offset: {offset} m from the middle of the {wall} wall is out of range (expected: within \
     ±{EXIT_REACH} m)"
)]
pub struct ExitOffWall {
    /// The wall.
    pub wall: Wall,
    /// The offset from the middle of the wall, in metres.
    pub offset: f64,
}

impl Exit {
    /// Creates an exit on `wall`, with its centre `offset` metres from the middle of the wall.
    ///
    /// The offset is along +y on the walls towards ±x and along +x on the walls towards ±y.
    ///
    /// # Errors
    ///
    /// Returns an error unless the offset is within ±[`EXIT_REACH`].
    pub fn new(wall: Wall, offset: f64) -> Result<Self, ExitOffWall> {
        if (-EXIT_REACH..=EXIT_REACH).contains(&offset) {
            Ok(Self { wall, offset })
        } else {
            Err(ExitOffWall { wall, offset })
        }
    }

    /// Returns the wall on which the exit is.
    pub fn wall(&self) -> Wall {
        self.wall
    }

    /// Returns the offset of the exit's centre from the middle of the wall, in metres.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Returns the pose of the exit's centre, on the inner face of the wall, in metres and radians.
    ///
    /// [`EXIT_DEPTH`] extends along the x axis of this pose, which points into the room, and
    /// [`EXIT_WIDTH`] along its y axis.
    pub fn pose(&self) -> Isometry2<f64> {
        self.wall.face(self.offset)
    }

    /// Returns whether the footprint touches the exit, which ends the episode.
    pub(super) fn touches(&self, footprint: &Footprint) -> bool {
        let half_sides = Vector::new((EXIT_DEPTH / 2.0) as f32, (EXIT_WIDTH / 2.0) as f32);
        footprint.touches(&contact::pose(&self.pose()), &Cuboid::new(half_sides))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    #[test]
    fn the_exit_extends_a_tenth_of_a_metre_into_the_room() {
        let exit = Exit::new(Wall::NegativeY, 0.5).unwrap();
        // The face of the exit is at y = -1.15; half the robot's side is 0.075 m.
        for (x, y, expected) in [
            (0.5, -1.074, false),
            (0.5, -1.076, true),
            (0.824, -1.15, true),
            (0.826, -1.15, false),
            (0.176, -1.15, true),
            (0.174, -1.15, false),
        ] {
            let footprint = Footprint::at(&Isometry2::new(Vector2::new(x, y), 0.0));
            assert_eq!(exit.touches(&footprint), expected, "({x}, {y})");
        }
    }

    #[test]
    fn rejects_an_exit_that_is_not_entirely_on_its_wall() {
        assert!(Exit::new(Wall::PositiveX, -1.0).is_ok());
        assert!(Exit::new(Wall::PositiveX, f64::NAN).is_err());
        assert_eq!(
            Exit::new(Wall::PositiveX, 1.2).unwrap_err().to_string(),
            "exit offset: 1.2 m from the middle of the +x wall is out of range (expected: within \
             ±1 m)"
        );
    }
}
