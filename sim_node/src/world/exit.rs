//! The exit: a box that stands half in a wall, half in the room.

use nalgebra::Isometry2;
use parry2d::math::Vector;
use parry2d::shape::Cuboid;

use super::contact;
use super::robot::Footprint;
use super::room::{ROOM_SIDE, Wall};

/// How wide the exit is along its wall, in metres.
pub const EXIT_WIDTH: f64 = 0.5;

/// How deep the exit is across its wall, in metres: half of it stands in the room.
pub const EXIT_DEPTH: f64 = 0.2;

/// The height of the exit, in metres.
pub const EXIT_HEIGHT: f64 = 1.0;

/// How far the exit's centre may be from the middle of its wall, in metres: all of it is on the
/// wall.
pub const EXIT_REACH: f64 = (ROOM_SIDE - EXIT_WIDTH) / 2.0;

/// Where the exit is: wholly on one of the walls, by construction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exit {
    wall: Wall,
    offset: f64,
}

/// The exit would not be on its wall.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "an exit {offset} m from the middle of the {wall} wall is not wholly on it: the offset is \
     within ±{EXIT_REACH} m"
)]
pub struct ExitOffWall {
    /// The wall.
    pub wall: Wall,
    /// The offset, in metres.
    pub offset: f64,
}

impl Exit {
    /// The exit on `wall`, centred `offset` metres from the wall's middle (along +y on the walls
    /// of x, along +x on the walls of y), within ±[`EXIT_REACH`].
    pub fn new(wall: Wall, offset: f64) -> Result<Self, ExitOffWall> {
        if (-EXIT_REACH..=EXIT_REACH).contains(&offset) {
            Ok(Self { wall, offset })
        } else {
            Err(ExitOffWall { wall, offset })
        }
    }

    /// The wall that it is on.
    pub fn wall(&self) -> Wall {
        self.wall
    }

    /// How far its centre is from the middle of the wall, in metres.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The pose of the box's centre, on the wall's inner face: [`EXIT_DEPTH`] is along x, which
    /// points into the room, and [`EXIT_WIDTH`] along y.
    pub fn pose(&self) -> Isometry2<f64> {
        self.wall.face(self.offset)
    }

    /// Whether the footprint reaches the exit: the robot has escaped.
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
    fn stands_a_tenth_of_a_metre_into_the_room() {
        let exit = Exit::new(Wall::NegativeY, 0.5).unwrap();
        // The exit's face is at y = -1.15, half of the robot is 0.075 m.
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
    fn an_exit_off_the_wall_is_refused() {
        assert!(Exit::new(Wall::PositiveX, -1.0).is_ok());
        assert!(Exit::new(Wall::PositiveX, f64::NAN).is_err());
        assert_eq!(
            Exit::new(Wall::PositiveX, 1.2).unwrap_err().to_string(),
            "an exit 1.2 m from the middle of the +x wall is not wholly on it: the offset is \
             within ±1 m"
        );
    }
}
