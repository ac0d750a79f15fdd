//! The camera's rays, in the order in which they fan out.

use nalgebra::{Rotation3, Vector2, Vector3};

use super::frame::{PIXELS, WIDTH};
use super::lens;

/// One pixel's ray, from the eye.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    /// A unit vector in the eye's frame: level, and turned with the robot.
    pub(crate) direction: Vector3<f64>,
    /// The pixel's index, counted row by row.
    pub(crate) pixel: usize,
}

/// All rays, from right to left by their azimuth.
///
/// An upright face, however high, is seen by rays between the azimuths of its two ends: two
/// binary searches find these, so that no ray is tested against a face that it cannot meet.
#[derive(Debug, Clone)]
pub(super) struct RayFan {
    rays: [Ray; PIXELS],
    azimuths: [f64; PIXELS],
}

impl RayFan {
    /// The rays of a camera that looks down by `pitch` radians.
    pub(super) fn new(pitch: f64) -> Self {
        let mount = Rotation3::from_axis_angle(&Vector3::y_axis(), pitch);
        let mut rays: [Ray; PIXELS] = std::array::from_fn(|pixel| {
            let direction = mount * lens::direction(pixel % WIDTH, pixel / WIDTH);
            Ray { direction, pixel }
        });
        let azimuth_of = |ray: &Ray| azimuth(&ray.direction.xy());
        rays.sort_by(|first, second| azimuth_of(first).total_cmp(&azimuth_of(second)));
        Self { azimuths: std::array::from_fn(|index| azimuth_of(&rays[index])), rays }
    }

    /// The rays.
    pub(super) fn rays(&self) -> &[Ray; PIXELS] {
        &self.rays
    }

    /// The indices of the rays from the direction `right`, counter-clockwise, to just before the
    /// direction `left`.
    #[inline(always)] // A fifth of the time of a picture with the concave wall.
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
        // From right to left through the direction behind the eye, the azimuth begins anew.
        if begin <= end { (begin..end).chain(0..0) } else { (begin..PIXELS).chain(0..end) }
    }
}

/// A number that grows with the azimuth of a direction, without the trigonometry: 0 ahead, 1 to
/// the left, -1 to the right, ±2 behind. Straight up and down count as ahead.
fn azimuth(direction: &Vector2<f64>) -> f64 {
    let ahead = direction.x / (direction.x.abs() + direction.y.abs());
    let aside = if ahead.is_nan() { 0.0 } else { 1.0 - ahead };
    if direction.y < 0.0 { -aside } else { aside }
}
