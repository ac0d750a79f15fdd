//! The intrinsics of the camera for sensor_msgs/CameraInfo, which has no stereographic model.
//!
//! The distortion model `equidistant` (Kannala and Brandt; `fisheye` in OpenCV) maps a direction at
//! angle theta from the optical axis to the following distance from the principal point, in pixels:
//!
//! ```text
//! f (theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9)
//! ```
//!
//! The stereographic [`super::lens`] maps the same direction to the following distance, where f is
//! a quarter of the image width:
//!
//! ```text
//! 2 f tan(theta / 2) = f (theta + theta^3 / 12 + theta^5 / 120 + 17 theta^7 / 20160 + ...)
//! ```
//!
//! Truncated after the theta^9 term, this series has an error of 0.013 pixels at the corners of the
//! image. The coefficients here are fitted to the whole field of view instead.

use super::frame::{HEIGHT, WIDTH};

/// Focal length in pixels, for both axes: 5.
pub const FOCAL_LENGTH: f64 = WIDTH as f64 / 4.0;

/// Principal point `[column, row]` in pixels: `[9.5, 3.0]`. (0, 0) is the centre of the upper left
/// pixel.
pub const PRINCIPAL_POINT: [f64; 2] = [(WIDTH - 1) as f64 / 2.0, (HEIGHT - 1) as f64 / 2.0];

/// Distortion coefficients `[k1, k2, k3, k4]`: a least-squares fit in pixels over all angles from
/// the optical axis to the corners of the image (93.3 degrees).
///
/// The model deviates from the lens by at most 0.0001 pixels (root mean square: 0.00002). OpenCV's
/// functions accept only angles below 90 degrees. The centres of all pixels meet this condition,
/// but the outer edges of the outermost columns do not.
pub const DISTORTION: [f64; 4] = [0.083249824086, 0.008590986883, 0.000588150288, 0.000180618941];

#[cfg(test)]
mod tests {
    use nalgebra::{ComplexField, DMatrix, DVector, RealField};

    use super::super::lens;
    use super::*;

    /// The angle between the optical axis and a corner of the image, in radians.
    fn field_of_view() -> f64 {
        2.0 * ComplexField::atan(1.0_f64.hypot(HEIGHT as f64 / WIDTH as f64))
    }

    /// The midpoints of `count` equal parts of the field of view, in radians.
    fn angles(count: usize) -> impl Iterator<Item = f64> {
        (0..count).map(move |part| field_of_view() * (part as f64 + 0.5) / count as f64)
    }

    /// The distance from the principal point to which the lens maps an angle, in pixels.
    fn lens_radius(angle: f64) -> f64 {
        WIDTH as f64 / 2.0 * ComplexField::tan(angle / 2.0)
    }

    /// The distance from the principal point to which the model maps an angle, in pixels.
    fn model_radius(angle: f64) -> f64 {
        let [k1, k2, k3, k4] = DISTORTION;
        let square = angle * angle;
        let series = 1.0 + square * (k1 + square * (k2 + square * (k3 + square * k4)));
        FOCAL_LENGTH * angle * series
    }

    #[test]
    fn the_coefficients_are_the_least_squares_fit() {
        const COUNT: usize = 1_000;
        // Angles relative to the field of view make the fit well conditioned.
        let power = |angle: f64, term: usize| (angle / field_of_view()).powi(2 * term as i32 + 3);
        let angles: Vec<f64> = angles(COUNT).collect();
        let powers = DMatrix::from_fn(COUNT, 4, |row, term| power(angles[row], term));
        let residuals = DVector::from_iterator(
            COUNT,
            angles.iter().map(|&angle| lens_radius(angle) / FOCAL_LENGTH - angle),
        );
        let fit = powers.svd(true, true).solve(&residuals, 1e-12).unwrap();
        for (term, expected) in DISTORTION.into_iter().enumerate() {
            let fitted = fit[term] / field_of_view().powi(2 * term as i32 + 3);
            assert!((fitted - expected).abs() < 1e-11, "k{}: {fitted} {expected}", term + 1);
        }
    }

    #[test]
    fn the_model_deviates_from_the_lens_by_at_most_a_ten_thousandth_of_a_pixel() {
        let errors: Vec<f64> =
            angles(10_000).map(|angle| model_radius(angle) - lens_radius(angle)).collect();
        let largest = errors.iter().fold(0.0_f64, |largest, error| largest.max(error.abs()));
        let mean_square = errors.iter().map(|error| error * error).sum::<f64>() / 10_000.0;
        assert!((0.000_09..0.000_1).contains(&largest), "{largest}");
        assert!(mean_square.sqrt() < 0.000_02, "{}", mean_square.sqrt());
    }

    #[test]
    fn the_model_projects_the_ray_of_each_pixel_to_that_pixel() {
        for (column, row) in (0..WIDTH).flat_map(|column| (0..HEIGHT).map(move |row| (column, row)))
        {
            let ray = lens::direction(column, row);
            // The optical frame: x right, y down, z forward.
            let (right, down, forward) = (-ray.y, -ray.z, ray.x);
            let off_axis = right.hypot(down);
            let radius = model_radius(RealField::atan2(off_axis, forward));
            let projected = [
                PRINCIPAL_POINT[0] + radius * right / off_axis,
                PRINCIPAL_POINT[1] + radius * down / off_axis,
            ];
            for (projected, pixel) in projected.into_iter().zip([column as f64, row as f64]) {
                assert!((projected - pixel).abs() < 0.000_1, "({column}, {row}): {projected}");
            }
        }
    }
}
