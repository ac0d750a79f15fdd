//! Colours and shading.

use nalgebra::{UnitComplex, Vector2, Vector3};

use super::frame::CHANNELS;

/// A colour as `[red, green, blue]`, each 0 to 1.
pub(crate) type Colour = [f64; CHANNELS];

/// Colour of the walls of the room.
pub(crate) const WALL: Colour = [0.0, 0.0, 1.0];
/// Colour of the exit.
pub(crate) const EXIT: Colour = [0.0, 1.0, 0.0];
/// Colour of the cylinders and the concave wall.
pub(crate) const OBSTACLE: Colour = [1.0, 0.0, 0.0];
/// Colour of the floor, which is not shaded.
pub(crate) const FLOOR: Colour = [0.5; CHANNELS];
/// Colour above the walls, which is not shaded.
pub(super) const SKY: Colour = [0.7; CHANNELS];

/// Direction of the light, not normalized: that of the sun in Gazebo's empty world.
const DIRECTION: Vector3<f64> = Vector3::new(-0.5, 0.1, -0.9);
/// Intensity of a face that the light does not reach.
const AMBIENT: f64 = 0.4;
/// Intensity that the light adds to a face perpendicular to it.
const DIFFUSE: f64 = 0.8;

/// Returns a colour as the bytes of a pixel.
pub(super) fn bytes(colour: Colour) -> [u8; CHANNELS] {
    colour.map(|channel| (255.0 * channel).round() as u8)
}

/// Returns the pixel of a surface that the light does not reach.
pub(super) fn ambient(colour: Colour) -> [u8; CHANNELS] {
    bytes(colour.map(|channel| AMBIENT * channel))
}

/// The directional light on vertical faces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Light {
    /// Horizontal part of the unit vector towards the light. The normals of vertical faces are
    /// horizontal, so the vertical part has no effect.
    towards: Vector2<f64>,
}

impl Light {
    /// Creates the light, in the frame of the world.
    pub(super) fn new() -> Self {
        Self { towards: -DIRECTION.xy() / DIRECTION.norm() }
    }

    /// Returns the light in a frame with this heading.
    pub(super) fn in_frame(&self, heading: &UnitComplex<f64>) -> Self {
        Self { towards: heading.inverse_transform_vector(&self.towards) }
    }

    /// Returns the pixel of a vertical face with this unit normal.
    pub(super) fn shade(&self, colour: Colour, normal: &Vector2<f64>) -> [u8; CHANNELS] {
        let intensity = (AMBIENT + DIFFUSE * normal.dot(&self.towards).max(0.0)).min(1.0);
        bytes(colour.map(|channel| intensity * channel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_four_walls_have_the_brightness_calculated_by_hand() {
        // The length of DIRECTION is sqrt(1.07) = 1.03441. A face towards +x receives
        // 0.5 / 1.03441 = 0.48337 of the light: 0.4 + 0.8 * 0.48337 = 0.78669, 200.6 of 255.
        // Towards -y: 0.1 / 1.03441 = 0.09667, so 0.47734, 121.7 of 255. The other two receive only
        // ambient light: 0.4 * 255 = 102.
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
