//! The room: a square interior, centred on the origin and surrounded by walls.

use std::fmt;

use nalgebra::{Isometry2, Translation2, UnitComplex};
use parry2d::math::Vector;
use parry2d::shape::HalfSpace;

use super::contact;
use super::robot::Footprint;

/// Inner side length of the square room in metres.
pub const ROOM_SIDE: f64 = 2.5;

/// Height of the walls in metres.
pub const WALL_HEIGHT: f64 = 1.0;

/// One of the four walls of the room, named after its direction from the centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wall {
    /// The wall towards +x.
    PositiveX,
    /// The wall towards +y.
    PositiveY,
    /// The wall towards -x.
    NegativeX,
    /// The wall towards -y.
    NegativeY,
}

impl Wall {
    /// All walls, counter-clockwise from +x.
    pub const ALL: [Self; 4] = [Self::PositiveX, Self::PositiveY, Self::NegativeX, Self::NegativeY];

    /// Returns a pose on the inner face of the wall, in metres and radians.
    ///
    /// Its x axis points into the room. Its origin is `offset` metres from the middle of the wall,
    /// along +y on the walls towards ±x and along +x on the walls towards ±y.
    pub fn face(self, offset: f64) -> Isometry2<f64> {
        const HALF: f64 = ROOM_SIDE / 2.0;
        let (x, y, inward_x, inward_y) = match self {
            Self::PositiveX => (HALF, offset, -1.0, 0.0),
            Self::PositiveY => (offset, HALF, 0.0, -1.0),
            Self::NegativeX => (-HALF, offset, 1.0, 0.0),
            Self::NegativeY => (offset, -HALF, 0.0, 1.0),
        };
        let inward = UnitComplex::from_cos_sin_unchecked(inward_x, inward_y);
        Isometry2::from_parts(Translation2::new(x, y), inward)
    }

    /// Returns whether the footprint touches the wall. A wall fills the half-plane behind its inner
    /// face, so no step can jump over it.
    pub(super) fn touches(self, footprint: &Footprint) -> bool {
        let solid = HalfSpace::new(Vector::X);
        footprint.touches(&contact::pose(&self.face(0.0)), &solid)
    }
}

impl fmt::Display for Wall {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::PositiveX => "+x",
            Self::PositiveY => "+y",
            Self::NegativeX => "-x",
            Self::NegativeY => "-y",
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    #[test]
    fn touches_the_side_or_the_corner_of_the_robot() {
        // Half the robot's side is 0.075 m; half its diagonal is 0.10607 m.
        for (x, degrees, expected) in [
            (1.174, 0.0_f64, false),
            (1.176, 0.0, true),
            (1.143, 45.0, false),
            (1.145, 45.0, true),
            (3.0, 10.0, true),
        ] {
            let footprint =
                Footprint::at(&Isometry2::new(Vector2::new(x, 0.3), degrees.to_radians()));
            assert_eq!(Wall::PositiveX.touches(&footprint), expected, "x {x}, {degrees} degrees");
            assert!(!Wall::NegativeX.touches(&footprint));
        }
    }

    #[test]
    fn faces_point_to_the_centre_of_the_room() {
        for wall in Wall::ALL {
            let ahead = wall.face(0.0) * nalgebra::Point2::new(ROOM_SIDE / 2.0, 0.0);
            assert!(ahead.coords.norm() < 1e-15, "{wall}");
        }
    }
}
