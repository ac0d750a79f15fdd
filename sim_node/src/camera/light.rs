//! Colours, and the light on them.

use nalgebra::{UnitComplex, Vector2, Vector3};

use super::frame::CHANNELS;

/// A colour by its red, green and blue, each 0 to 1.
pub(crate) type Colour = [f64; CHANNELS];

/// The room's walls.
pub(crate) const WALL: Colour = [0.0, 0.0, 1.0];
/// The exit.
pub(crate) const EXIT: Colour = [0.0, 1.0, 0.0];
/// Cylinders and the concave wall.
pub(crate) const OBSTACLE: Colour = [1.0, 0.0, 0.0];
/// The floor, which is not shaded.
pub(crate) const FLOOR: Colour = [0.5; CHANNELS];
/// What is above the walls, which is not shaded.
pub(super) const SKY: Colour = [0.7; CHANNELS];

/// Where the light goes, before its length is made 1: the sun of Gazebo's empty world.
const DIRECTION: Vector3<f64> = Vector3::new(-0.5, 0.1, -0.9);
/// How bright everything is at least.
const AMBIENT: f64 = 0.4;
/// How much the light adds to a face that looks straight at it.
const DIFFUSE: f64 = 0.8;

/// A colour as an image has it.
pub(super) fn bytes(colour: Colour) -> [u8; CHANNELS] {
    colour.map(|channel| (255.0 * channel).round() as u8)
}

/// A colour that the light does not reach.
pub(super) fn in_the_dark(colour: Colour) -> [u8; CHANNELS] {
    bytes(colour.map(|channel| AMBIENT * channel))
}

/// The light, as upright faces see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Light {
    /// The horizontal part of the unit vector towards the light: an upright face has a horizontal
    /// normal, so that the rest does not count.
    towards: Vector2<f64>,
}

impl Light {
    /// The light in the frame of the world.
    pub(super) fn new() -> Self {
        Self { towards: -DIRECTION.xy() / DIRECTION.norm() }
    }

    /// The light in a frame that is turned by `heading`.
    pub(super) fn seen_from(&self, heading: &UnitComplex<f64>) -> Self {
        Self { towards: heading.inverse_transform_vector(&self.towards) }
    }

    /// The colour of an upright face with this unit normal.
    pub(super) fn shade(&self, colour: Colour, normal: &Vector2<f64>) -> [u8; CHANNELS] {
        let intensity = (AMBIENT + DIFFUSE * normal.dot(&self.towards).max(0.0)).min(1.0);
        bytes(colour.map(|channel| intensity * channel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_four_directions_have_the_brightness_worked_out_by_hand() {
        // The length of the direction is sqrt(1.07) = 1.03441. Towards +x the face sees
        // 0.5 / 1.03441 = 0.48337 of the light: 0.4 + 0.8 * 0.48337 = 0.78669, 200.6 of 255.
        // Towards -y: 0.1 / 1.03441 = 0.09667, 0.47734, 121.7. The others are in the shade:
        // 0.4 * 255 = 102.
        let light = Light::new();
        for (x, y, expected) in
            [(1.0, 0.0, 201), (0.0, -1.0, 122), (-1.0, 0.0, 102), (0.0, 1.0, 102)]
        {
            assert_eq!(light.shade(WALL, &Vector2::new(x, y)), [0, 0, expected], "({x}, {y})");
        }
    }

    #[test]
    fn floor_and_sky_are_grey() {
        assert_eq!(bytes(FLOOR), [128; 3]);
        assert_eq!(bytes(SKY), [179; 3]);
    }
}
