//! Motion of the moving cylinders.

use std::f64::consts::PI;

use nalgebra::{Point2, UnitComplex, Vector2};
use task::Random;

use super::cylinder::{self, Cylinder};
use super::robot::Footprint;
use super::spacing::Spacing;

/// Distance that a moving cylinder moves in one step of the robot, in metres.
pub const CYLINDER_STEP_LENGTH: f64 = 0.025;

/// Moves every cylinder, in order, by one step.
///
/// First, the heading of the cylinder changes by a normally distributed angle with the standard
/// deviation `heading_deviation`, in radians. Then the cylinder moves by `step_length`, in metres,
/// if its new position is in the central square, far enough from the other cylinders and clear of
/// the robot. Otherwise, it stays in place and gets a new heading drawn uniformly at random.
pub(super) fn move_cylinders(
    cylinders: &mut [Cylinder],
    robot: &Footprint,
    step_length: f64,
    heading_deviation: f64,
    random: &mut Random,
) {
    for index in 0..cylinders.len() {
        let mut pose = cylinders[index].pose;
        pose.append_rotation_wrt_center_mut(&UnitComplex::new(random.normal(heading_deviation)));
        pose.rotation.renormalize();
        let step = pose.rotation * Vector2::new(step_length, 0.0);
        let next = Point2::from(pose.translation.vector + step);
        if is_free(&next, index, cylinders, robot) {
            pose.translation = next.into();
        } else {
            pose.rotation = UnitComplex::new(random.within(PI));
        }
        cylinders[index].pose = pose;
    }
}

/// Returns whether the cylinder with this index may move to `centre`.
fn is_free(centre: &Point2<f64>, index: usize, cylinders: &[Cylinder], robot: &Footprint) -> bool {
    const SPACING: Spacing = Spacing::MOVING;
    let mut others = cylinders.iter().enumerate().filter(|&(other, _)| other != index);
    SPACING.contains(centre)
        && others.all(|(_, other)| SPACING.separates(&other.centre(), centre))
        && !cylinder::touches_at(centre, robot)
}
