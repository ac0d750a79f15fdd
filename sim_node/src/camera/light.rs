//! Colours and shading.

use nalgebra::{UnitComplex, Vector2, Vector3};

use super::frame::CHANNELS;
use crate::reality::{LightConditions, SurfaceConditions, Tint};

/// A colour as `[red, green, blue]`, each 0 to 1.
pub(crate) type Colour = [f64; CHANNELS];

/// The colours of all surfaces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Palette {
    pub(super) wall: Colour,
    pub(super) exit: Colour,
    pub(super) obstacle: Colour,
    pub(super) floor: Colour,
    pub(super) sky: Colour,
}

impl Palette {
    /// Returns the colours under these conditions.
    pub(super) fn new(surfaces: &SurfaceConditions) -> Palette {
        Palette {
            wall: tinted(WALL, &surfaces.wall),
            exit: tinted(EXIT, &surfaces.exit),
            obstacle: tinted(OBSTACLE, &surfaces.obstacle),
            floor: tinted(FLOOR, &surfaces.floor),
            sky: tinted(SKY, &surfaces.sky),
        }
    }
}

/// Returns a colour with its hue turned and its brightness changed. Channels can exceed 1; the
/// image saturates.
fn tinted(colour: Colour, tint: &Tint) -> Colour {
    if *tint == Tint::default() {
        return colour;
    }
    let high = colour.into_iter().fold(0.0, f64::max);
    let low = colour.into_iter().fold(1.0, f64::min);
    // Around the hexagon of the colour model HSV, a channel rises over 60 degrees, is high over
    // 120, falls over 60 and is low over 120.
    let hue = match colour {
        _ if high == low => 0.0,
        [red, green, _] if red == high && green > low => 60.0 * (green - low) / (high - low),
        [red, _, blue] if red == high => -60.0 * (blue - low) / (high - low),
        [red, green, blue] if green == high => 120.0 + 60.0 * (blue - red) / (high - low),
        [red, green, _] => 240.0 + 60.0 * (red - green) / (high - low),
    };
    let hue = hue + tint.hue.to_degrees();
    [0.0, 120.0, 240.0].map(|centre| {
        let distance = ((hue - centre + 180.0).rem_euclid(360.0) - 180.0).abs();
        let share = (2.0 - distance / 60.0).clamp(0.0, 1.0);
        tint.brightness * (low + share * (high - low))
    })
}

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
    pub(super) fn new(conditions: &LightConditions) -> Self {
        let towards = -DIRECTION.xy() / DIRECTION.norm();
        if *conditions == LightConditions::default() {
            return Self { towards };
        }
        let horizontal = towards.norm();
        let elevation = libm::acos(horizontal) + conditions.elevation;
        let azimuth = UnitComplex::new(conditions.azimuth);
        Self { towards: azimuth * towards * (libm::cos(elevation) / horizontal) }
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
        let light = Light::new(&LightConditions::default());
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

    #[test]
    fn a_tint_turns_the_hue_and_changes_the_brightness() {
        let tint = |hue: f64, brightness| Tint { hue: hue.to_radians(), brightness };
        for (colour, hue, brightness, expected) in [
            (OBSTACLE, 30.0, 1.0, [1.0, 0.5, 0.0]),
            (OBSTACLE, -30.0, 1.0, [1.0, 0.0, 0.5]),
            (EXIT, 30.0, 0.8, [0.0, 0.8, 0.4]),
            (WALL, -30.0, 1.0, [0.0, 0.5, 1.0]),
            (WALL, 30.0, 1.0, [0.5, 0.0, 1.0]),
            (FLOOR, 90.0, 1.1, [0.55; 3]),
            ([0.2, 0.6, 1.0], 0.0, 0.5, [0.1, 0.3, 0.5]),
            ([1.0, 0.6, 0.2], 0.0, 0.5, [0.5, 0.3, 0.1]),
        ] {
            let found = tinted(colour, &tint(hue, brightness));
            let close = found
                .iter()
                .zip(expected)
                .all(|(found, expected)| (found - expected).abs() < 1e-12);
            assert!(close, "{colour:?} turned by {hue}: {found:?}, expected {expected:?}");
        }
    }

    #[test]
    fn the_direction_of_the_light_turns_about_the_vertical_axis_and_rises() {
        let exact = Light::new(&LightConditions::default()).towards;
        let turned = LightConditions { azimuth: 0.5, elevation: 0.0 };
        let turned = Light::new(&turned).towards;
        assert!((turned - UnitComplex::new(0.5) * exact).norm() < 1e-12);
        // A light at the zenith does not reach vertical faces.
        let zenith = std::f64::consts::FRAC_PI_2 - libm::acos(exact.norm());
        let zenith = LightConditions { azimuth: 0.0, elevation: zenith };
        assert!(Light::new(&zenith).towards.norm() < 1e-12);
    }
}
