//! The rays of the camera, sorted by azimuth.

use nalgebra::{Rotation3, Vector2, Vector3};

use super::frame::{PIXELS, WIDTH};
use super::lens;

/// The ray of one pixel. It starts at the eye.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    /// Unit vector in the frame of the eye: x forward along the heading of the robot, y left, z up.
    /// The mount of the camera is included.
    pub(crate) direction: Vector3<f64>,
    /// Index of the pixel, row-major.
    pub(crate) pixel: usize,
}

/// All rays, sorted by azimuth from right to left.
///
/// Only the rays between the azimuths of the two ends of a vertical face can hit it. Two binary
/// searches find them, so no other ray is tested against the face.
#[derive(Debug, Clone)]
pub(super) struct RayFan {
    rays: [Ray; PIXELS],
    azimuths: [f64; PIXELS],
}

impl RayFan {
    /// Creates the rays of a camera with this mount, from the frame of the camera to that of the
    /// eye. `lens_error` is the relative error of the field of view.
    pub(super) fn new(mount: &Rotation3<f64>, lens_error: f64) -> Self {
        let mut rays: [Ray; PIXELS] = std::array::from_fn(|pixel| {
            let (column, row) = (pixel % WIDTH, pixel / WIDTH);
            let direction = match lens_error == 0.0 {
                true => lens::direction(column, row),
                false => lens::direction_with_error(column, row, lens_error),
            };
            Ray { direction: mount * direction, pixel }
        });
        let azimuth_of = |ray: &Ray| azimuth(&ray.direction.xy());
        rays.sort_by(|first, second| azimuth_of(first).total_cmp(&azimuth_of(second)));
        Self { azimuths: std::array::from_fn(|index| azimuth_of(&rays[index])), rays }
    }

    /// Returns the rays, from right to left.
    pub(super) fn rays(&self) -> &[Ray; PIXELS] {
        &self.rays
    }

    /// Returns the indices of the rays counter-clockwise from the direction `right` to the
    /// direction `left`, which is excluded.
    #[inline(always)] // Saves a fifth of the render time with the concave wall.
    pub(super) fn between(
        &self,
        right: &Vector2<f64>,
        left: &Vector2<f64>,
    ) -> impl Iterator<Item = usize> + use<> {
        let first = |direction| {
            let azimuth = azimuth(direction);
            self.azimuths.partition_point(|&other| other < azimuth)
        };
        let (begin, end) = (first(right), first(left));
        // The azimuth wraps around behind the eye.
        if begin <= end { (begin..end).chain(0..0) } else { (begin..PIXELS).chain(0..end) }
    }
}

/// Returns a monotonic function of a direction's azimuth, computed without trigonometry: 0 ahead, 1
/// to the left, -1 to the right, ±2 behind. Straight up and straight down count as ahead.
fn azimuth(direction: &Vector2<f64>) -> f64 {
    let forward = direction.x / (direction.x.abs() + direction.y.abs());
    let sideways = if forward.is_nan() { 0.0 } else { 1.0 - forward };
    if direction.y < 0.0 { -sideways } else { sideways }
}
