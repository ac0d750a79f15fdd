//! Converts poses in double precision to parry's single precision, and tests for contact.

use nalgebra::{Isometry2, Point2};
use parry2d::math::{Pose, Rot2, Vector};
use parry2d::query;
use parry2d::shape::Shape;

/// Converts a pose to parry's type.
pub(crate) fn pose(pose: &Isometry2<f64>) -> Pose {
    let translation = Vector::new(pose.translation.x as f32, pose.translation.y as f32);
    // Copies cosine and sine: a conversion through the angle would cost three trigonometric calls.
    let rotation = Rot2::from_cos_sin_unchecked(pose.rotation.re as f32, pose.rotation.im as f32);
    Pose::from_parts(translation, rotation)
}

/// Converts a point to parry's type.
pub(crate) fn point(point: &Point2<f64>) -> Vector {
    Vector::new(point.x as f32, point.y as f32)
}

/// Returns whether two solids have a point in common.
pub(super) fn touch(
    first_pose: &Pose,
    first: &dyn Shape,
    second_pose: &Pose,
    second: &dyn Shape,
) -> bool {
    query::intersection_test(first_pose, first, second_pose, second)
        .expect("parry supports a square against every shape in this world")
        .intersecting
}
