//! How moving cylinders move.

use std::f64::consts::PI;

use nalgebra::{Point2, UnitComplex, Vector2};
use task::Random;

use super::cylinder::{self, Cylinder};
use super::robot::Footprint;
use super::spacing::Spacing;

/// How far a moving cylinder goes in one step of the robot, in metres.
pub const CYLINDER_STEP_LENGTH: f64 = 0.025;

/// Lets every cylinder in turn take one step.
///
/// First its heading changes by a normally distributed angle of the given standard deviation, in
/// radians; then it steps, if that keeps it in the central square, apart from the other cylinders
/// and clear of the robot. Otherwise it stays and faces a uniform new heading.
pub(super) fn wander(
    cylinders: &mut [Cylinder],
    robot: &Footprint,
    heading_deviation: f64,
    random: &mut Random,
) {
    for index in 0..cylinders.len() {
        let mut pose = cylinders[index].pose;
        pose.append_rotation_wrt_center_mut(&UnitComplex::new(random.normal(heading_deviation)));
        pose.rotation.renormalize();
        let step = pose.rotation * Vector2::new(CYLINDER_STEP_LENGTH, 0.0);
        let next = Point2::from(pose.translation.vector + step);
        if is_free(&next, index, cylinders, robot) {
            pose.translation = next.into();
        } else {
            pose.rotation = UnitComplex::new(random.within(PI));
        }
        cylinders[index].pose = pose;
    }
}

/// Whether the cylinder with this index may be at `centre`.
fn is_free(centre: &Point2<f64>, index: usize, cylinders: &[Cylinder], robot: &Footprint) -> bool {
    const RULE: Spacing = Spacing::MOVING;
    let mut others = cylinders.iter().enumerate().filter(|&(other, _)| other != index);
    RULE.contains(centre)
        && others.all(|(_, other)| RULE.separates(&other.centre(), centre))
        && !cylinder::touches_at(centre, robot)
}
