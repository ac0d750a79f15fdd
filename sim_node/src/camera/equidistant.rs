//! The lens in the words of sensor_msgs/CameraInfo, which knows no stereographic one.
//!
//! The model `equidistant` (Kannala and Brandt's, OpenCV's `fisheye`) shows what is theta away from
//! the optical axis at the distance f (theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9)
//! from the middle, in pixels. The stereographic [`super::lens`] shows it at half a width times
//! tan(theta / 2), which is f (theta + theta^3 / 12 + theta^5 / 120 + 17 theta^7 / 20160 + ...) with
//! f a quarter of the width. That series converges too slowly to be cut off after four terms: at the
//! corners it would be 0.013 pixels off. Coefficients fitted to the whole field of view are not.

use super::frame::{HEIGHT, WIDTH};

/// The focal length in pixels, the same in both directions.
pub const FOCAL_LENGTH: f64 = WIDTH as f64 / 4.0;

/// Where the optical axis meets the image: column and row in pixels, counted from 0 at the middle of
/// the first one.
pub const PRINCIPAL_POINT: [f64; 2] = [(WIDTH - 1) as f64 / 2.0, (HEIGHT - 1) as f64 / 2.0];

/// The coefficients k1 to k4: a least-squares fit in pixels over the angles of the field of view,
/// from the axis to the corners of the image, 93.3 degrees away.
///
/// Nowhere in the image is the model more than 0.0001 pixels from the lens (root mean square:
/// 0.00002). OpenCV's own functions take only what is less than 90 degrees from the axis, as the
/// middles of all pixels are, but not the outer parts of the outer columns.
pub const DISTORTION: [f64; 4] = [0.083249824086, 0.008590986883, 0.000588150288, 0.000180618941];

#[cfg(test)]
mod tests {
    use nalgebra::{ComplexField, DMatrix, DVector, RealField};

    use super::super::lens;
    use super::*;

    /// From the optical axis to a corner of the image: half a width is 1.
    fn field_of_view() -> f64 {
        2.0 * ComplexField::atan(1.0_f64.hypot(HEIGHT as f64 / WIDTH as f64))
    }

    /// Angles in the middles of equal parts of the field of view.
    fn angles(count: usize) -> impl Iterator<Item = f64> {
        (0..count).map(move |part| field_of_view() * (part as f64 + 0.5) / count as f64)
    }

    /// How far from the middle the lens shows an angle, in pixels.
    fn by_lens(angle: f64) -> f64 {
        WIDTH as f64 / 2.0 * ComplexField::tan(angle / 2.0)
    }

    /// How far from the middle the model shows it.
    fn by_model(angle: f64) -> f64 {
        let [k1, k2, k3, k4] = DISTORTION;
        let square = angle * angle;
        let series = 1.0 + square * (k1 + square * (k2 + square * (k3 + square * k4)));
        FOCAL_LENGTH * angle * series
    }

    #[test]
    fn the_coefficients_are_the_least_squares_fit() {
        const COUNT: usize = 1_000;
        // In parts of the field of view the powers are alike in size, and the fit well conditioned.
        let power = |angle: f64, term: usize| (angle / field_of_view()).powi(2 * term as i32 + 3);
        let angles: Vec<f64> = angles(COUNT).collect();
        let powers = DMatrix::from_fn(COUNT, 4, |row, term| power(angles[row], term));
        let rest = DVector::from_iterator(
            COUNT,
            angles.iter().map(|&angle| by_lens(angle) / FOCAL_LENGTH - angle),
        );
        let fit = powers.svd(true, true).solve(&rest, 1e-12).unwrap();
        for (term, expected) in DISTORTION.into_iter().enumerate() {
            let fitted = fit[term] / field_of_view().powi(2 * term as i32 + 3);
            assert!((fitted - expected).abs() < 1e-11, "k{}: {fitted} {expected}", term + 1);
        }
    }

    #[test]
    fn the_model_is_within_a_ten_thousandth_of_a_pixel() {
        let errors: Vec<f64> =
            angles(10_000).map(|angle| by_model(angle) - by_lens(angle)).collect();
        let largest = errors.iter().fold(0.0_f64, |largest, error| largest.max(error.abs()));
        let mean_square = errors.iter().map(|error| error * error).sum::<f64>() / 10_000.0;
        assert!((0.000_09..0.000_1).contains(&largest), "{largest}");
        assert!(mean_square.sqrt() < 0.000_02, "{}", mean_square.sqrt());
    }

    /// What a pixel looks at, projected by the model, is that pixel.
    #[test]
    fn the_model_projects_every_ray_to_its_pixel() {
        for (column, row) in (0..WIDTH).flat_map(|column| (0..HEIGHT).map(move |row| (column, row)))
        {
            let ray = lens::direction(column, row);
            // The optical frame: x right, y down, z ahead.
            let (right, down, ahead) = (-ray.y, -ray.z, ray.x);
            let aside = right.hypot(down);
            let from_middle = by_model(RealField::atan2(aside, ahead));
            let projected = [
                PRINCIPAL_POINT[0] + from_middle * right / aside,
                PRINCIPAL_POINT[1] + from_middle * down / aside,
            ];
            for (projected, pixel) in projected.into_iter().zip([column as f64, row as f64]) {
                assert!((projected - pixel).abs() < 0.000_1, "({column}, {row}): {projected}");
            }
        }
    }
}
