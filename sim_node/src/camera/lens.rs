//! The lens: a stereographic projection that spans 180 degrees across the image width.
//!
//! A point at distance r from the centre of the image, in units of half the width, shows the
//! direction at angle 2 atan(r) from the optical axis. The projection is conformal: it preserves
//! the shapes of small objects everywhere in the image.

use nalgebra::Vector3;

use super::frame::{HEIGHT, WIDTH};

/// Returns the viewing direction of the centre of a pixel, for a level camera.
///
/// The result is a unit vector with x forward, y left and z up. Columns are numbered 0..=19 from
/// the left, rows 0..=6 from the top.
pub fn direction(column: usize, row: usize) -> Vector3<f64> {
    let (right, down) = position(column, row);
    // The cosine and sine of 2 atan(r) are (1 - r^2) / (1 + r^2) and 2 r / (1 + r^2).
    let square = right * right + down * down;
    Vector3::new(1.0 - square, -2.0 * right, -2.0 * down) / (1.0 + square)
}

/// Like [`direction`], for a lens whose field of view has the relative error `error`: all angles
/// from the optical axis are multiplied by 1 + `error`.
pub fn direction_with_error(column: usize, row: usize, error: f64) -> Vector3<f64> {
    let (right, down) = position(column, row);
    // No pixel centre is on the optical axis, because the number of columns is even.
    let radius = (right * right + down * down).sqrt();
    let (sine, cosine) = libm::sincos(2.0 * (1.0 + error) * libm::atan(radius));
    Vector3::new(cosine, -sine * right / radius, -sine * down / radius)
}

/// Returns the position of the centre of a pixel, to the right of and below the optical axis, in
/// units of half the image width.
fn position(column: usize, row: usize) -> (f64, f64) {
    let right = (2 * column + 1) as f64 / WIDTH as f64 - 1.0;
    let down = ((2 * row + 1) as f64 - HEIGHT as f64) / WIDTH as f64;
    (right, down)
}

#[cfg(test)]
mod tests {
    use nalgebra::ComplexField;

    use super::*;

    fn assert_close(actual: Vector3<f64>, expected: [f64; 3]) {
        let difference = (actual - Vector3::from(expected)).norm();
        assert!(difference < 1e-12, "{actual}, expected {expected:?}");
    }

    #[test]
    fn the_middle_columns_look_5_72_degrees_to_the_sides() {
        // r = 0.05: (1 - 0.0025) / 1.0025 forward and 0.1 / 1.0025 to the side, 5.72 degrees.
        assert_close(direction(9, 3), [0.9975 / 1.0025, 0.1 / 1.0025, 0.0]);
        assert_close(direction(10, 3), [0.9975 / 1.0025, -0.1 / 1.0025, 0.0]);
        // The top row: down = -0.3 and r^2 = 0.0925.
        assert_close(direction(10, 0), [0.9075 / 1.0925, -0.1 / 1.0925, 0.6 / 1.0925]);
    }

    #[test]
    fn the_width_spans_180_degrees() {
        // The edges are at r = 1, which is 2 atan(1) = 90 degrees from the axis. The centres of the
        // outermost pixels are at r = 0.95, which is 87.06 degrees from the axis.
        let outer: f64 = 2.0 * ComplexField::atan(0.95);
        assert!((outer.to_degrees() - 87.0624).abs() < 1e-4);
        let (sine, cosine) = ComplexField::sin_cos(outer);
        assert_close(direction(0, 3), [cosine, sine, 0.0]);
        assert_close(direction(19, 3), [cosine, -sine, 0.0]);
    }

    #[test]
    fn an_error_of_the_field_of_view_scales_the_angles_from_the_axis() {
        for (column, row) in [(0, 0), (9, 3), (13, 5), (19, 6)] {
            let exact = direction(column, row);
            assert_close(direction_with_error(column, row, 0.0), exact.into());
            let wide = direction_with_error(column, row, 0.05);
            let angle = |ray: Vector3<f64>| libm::acos(ray.x);
            assert!((angle(wide) / angle(exact) - 1.05).abs() < 1e-9);
            assert!((wide.yz().normalize() - exact.yz().normalize()).norm() < 1e-12);
        }
    }

    #[test]
    fn directions_are_symmetric_unit_vectors() {
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
