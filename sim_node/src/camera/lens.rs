//! The lens: stereographic, 180 degrees across the width of the image.
//!
//! A point of the image at the distance r from its middle (half the width is 1) shows what is
//! 2 atan(r) away from the optical axis. The projection keeps angles, so that a small thing has
//! its own shape everywhere in the image.

use nalgebra::Vector3;

use super::frame::{HEIGHT, WIDTH};

/// The direction that the middle of a pixel of a level camera looks in: a unit vector, x forward,
/// y left, z up.
pub fn direction(column: usize, row: usize) -> Vector3<f64> {
    let right = (2 * column + 1) as f64 / WIDTH as f64 - 1.0;
    let down = ((2 * row + 1) as f64 - HEIGHT as f64) / WIDTH as f64;
    // The cosine and sine of 2 atan(r) are (1 - r^2) / (1 + r^2) and 2 r / (1 + r^2).
    let square = right * right + down * down;
    Vector3::new(1.0 - square, -2.0 * right, -2.0 * down) / (1.0 + square)
}

#[cfg(test)]
mod tests {
    use nalgebra::ComplexField;

    use super::*;

    fn assert_close(actual: Vector3<f64>, expected: [f64; 3]) {
        assert!((actual - Vector3::from(expected)).norm() < 1e-12, "{actual} is not {expected:?}");
    }

    #[test]
    fn the_middle_columns_look_almost_ahead() {
        // r = 0.05: (1 - 0.0025) / 1.0025 ahead and 0.1 / 1.0025 aside, 5.72 degrees.
        assert_close(direction(9, 3), [0.9975 / 1.0025, 0.1 / 1.0025, 0.0]);
        assert_close(direction(10, 3), [0.9975 / 1.0025, -0.1 / 1.0025, 0.0]);
        // The upper row: down = -0.3 and r^2 = 0.0925.
        assert_close(direction(10, 0), [0.9075 / 1.0925, -0.1 / 1.0925, 0.6 / 1.0925]);
    }

    #[test]
    fn the_width_is_half_a_circle() {
        // The outer pixels' middles are at r = 0.95, the edges at 1, which is 2 atan(1) = 90
        // degrees: the middle of the outer pixel looks 87.06 degrees aside.
        let outer: f64 = 2.0 * ComplexField::atan(0.95);
        assert!((outer.to_degrees() - 87.0624).abs() < 1e-4);
        let (sine, cosine) = ComplexField::sin_cos(outer);
        assert_close(direction(0, 3), [cosine, sine, 0.0]);
        assert_close(direction(19, 3), [cosine, -sine, 0.0]);
    }

    #[test]
    fn directions_have_length_one_and_mirror_each_other() {
        for row in 0..HEIGHT {
            for column in 0..WIDTH {
                let ray = direction(column, row);
                assert!((ray.norm() - 1.0).abs() < 1e-15);
                assert_close(direction(WIDTH - 1 - column, row), [ray.x, -ray.y, ray.z]);
                assert_close(direction(column, HEIGHT - 1 - row), [ray.x, ray.y, -ray.z]);
            }
        }
    }
}
