//! Where the world's poses (double precision) meet parry's shapes (single precision).

use nalgebra::{Isometry2, Point2};
use parry2d::math::{Pose, Rot2, Vector};
use parry2d::query;
use parry2d::shape::Shape;

/// A pose as parry has it.
pub(crate) fn pose(pose: &Isometry2<f64>) -> Pose {
    let translation = Vector::new(pose.translation.x as f32, pose.translation.y as f32);
    // By its parts: an angle would cost an arc tangent, a sine and a cosine.
    let rotation = Rot2::from_cos_sin_unchecked(pose.rotation.re as f32, pose.rotation.im as f32);
    Pose::from_parts(translation, rotation)
}

/// A point as parry has it.
pub(crate) fn point(point: &Point2<f64>) -> Vector {
    Vector::new(point.x as f32, point.y as f32)
}

/// Whether two solids have a point in common.
pub(super) fn touch(
    first_pose: &Pose,
    first: &dyn Shape,
    second_pose: &Pose,
    second: &dyn Shape,
) -> bool {
    query::intersection_test(first_pose, first, second_pose, second)
        .expect("parry knows how to test a square against each shape of this world")
        .intersecting
}
