//! The robot: a square that turns and moves forward.

use nalgebra::{Isometry2, UnitComplex, Vector2};
use parry2d::math::{Pose, Vector};
use parry2d::shape::{Cuboid, Shape};

use super::contact;

/// Side length of the robot's square footprint in metres.
pub const FOOTPRINT_SIDE: f64 = 0.15;

/// Returns the pose after a move that is not blocked: first the turn, in radians, then the distance
/// forward, in metres (equation 3 of the paper).
pub(super) fn moved(robot: &Isometry2<f64>, turn: f64, distance: f64) -> Isometry2<f64> {
    advanced(&turned(robot, turn), distance)
}

fn turned(robot: &Isometry2<f64>, turn: f64) -> Isometry2<f64> {
    let mut turned = *robot;
    turned.append_rotation_wrt_center_mut(&UnitComplex::new(turn));
    // Each product of rotations is rounded. Without renormalization, the heading would lose its
    // unit length.
    turned.rotation.renormalize();
    turned
}

fn advanced(robot: &Isometry2<f64>, distance: f64) -> Isometry2<f64> {
    let mut advanced = *robot;
    advanced.translation.vector += robot.rotation * Vector2::new(distance, 0.0);
    advanced
}

/// Returns the pose at which a blocked wheeled robot stops: it turns as far as it can, then advances
/// until just before contact.
///
/// `touches` tells whether the robot would touch something at a pose. It does not at its current
/// pose, and not at the returned one, which is within 0.1 mm or 0.1 degrees of contact.
pub(super) fn stopped_short(
    robot: &Isometry2<f64>,
    turn: f64,
    distance: f64,
    touches: impl Fn(&Isometry2<f64>) -> bool,
) -> Isometry2<f64> {
    // In 3 degrees a corner of the footprint moves by 5.6 mm. All obstacles are thicker.
    let sectors = (turn.abs() / 3_f64.to_radians()).ceil();
    let robot = furthest(sectors, |share| turned(robot, share * turn), &touches);
    let sections = (distance / 0.005).ceil();
    furthest(sections, |share| advanced(&robot, share * distance), &touches)
}

/// Returns the last pose on a path before the first contact. `pose_at` maps 0 to 1 to the path,
/// whose start is free; the path is tested at the ends of equal sections.
fn furthest(
    sections: f64,
    pose_at: impl Fn(f64) -> Isometry2<f64>,
    touches: impl Fn(&Isometry2<f64>) -> bool,
) -> Isometry2<f64> {
    let sections = sections.max(1.0);
    let end_of = |section: u32| f64::from(section) / sections;
    let first = (1..=sections as u32).find(|section| touches(&pose_at(end_of(*section))));
    let Some(first) = first else {
        return pose_at(1.0);
    };
    let (mut free, mut blocked) = (end_of(first - 1), end_of(first));
    // Halves a section of 5 mm to less than 0.1 mm.
    for _ in 0..6 {
        let middle = 0.5 * (free + blocked);
        if touches(&pose_at(middle)) { blocked = middle } else { free = middle }
    }
    pose_at(free)
}

/// The area of the ground plan that the robot covers at a pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Footprint {
    pose: Pose,
    shape: Cuboid,
}

impl Footprint {
    /// Returns the footprint of the robot at the pose `robot`.
    pub(super) fn at(robot: &Isometry2<f64>) -> Self {
        let half_side = (FOOTPRINT_SIDE / 2.0) as f32;
        Self { pose: contact::pose(robot), shape: Cuboid::new(Vector::splat(half_side)) }
    }

    /// Returns whether the footprint has a point in common with `shape` at `pose`.
    pub(super) fn touches(&self, pose: &Pose, shape: &dyn Shape) -> bool {
        contact::touch(&self.pose, &self.shape, pose, shape)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4};

    use task::{Action, action::STEP_LENGTH};

    use super::*;

    #[test]
    fn an_action_turns_before_it_moves_forward() {
        let robot = Isometry2::new(Vector2::new(0.5, -0.25), FRAC_PI_2);
        let moved = moved(&robot, Action::ALL[2].turn(), STEP_LENGTH);
        let side = STEP_LENGTH * FRAC_1_SQRT_2;
        let expected = Vector2::new(0.5 + side, -0.25 + side);
        assert!((moved.translation.vector - expected).norm() < 1e-15);
        assert!((moved.rotation.angle() - FRAC_PI_2 / 2.0).abs() < 1e-15);
    }

    #[test]
    fn the_heading_keeps_its_unit_length_over_a_million_actions() {
        let mut robot = Isometry2::identity();
        for turn in 0..1_000_000 {
            robot = moved(&robot, Action::ALL[turn % Action::COUNT].turn(), STEP_LENGTH);
        }
        let length = robot.rotation.re * robot.rotation.re + robot.rotation.im * robot.rotation.im;
        assert!((length - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_robot_that_stops_short_turns_and_advances_until_it_touches_something() {
        let wall = |x: f64| move |pose: &Isometry2<f64>| pose.translation.x + 0.075 > x;
        let stopped = stopped_short(&Isometry2::identity(), 0.0, 0.15, wall(0.1));
        let gap = 0.025 - stopped.translation.x;
        assert!((0.0..1e-4).contains(&gap), "{gap}");
        // The turn is free, and the robot then advances along the wall.
        let stopped = stopped_short(&Isometry2::identity(), FRAC_PI_2, 0.15, wall(0.1));
        assert!((stopped.translation.vector - Vector2::new(0.0, 0.15)).norm() < 1e-15);
        // The turn ends at 45 degrees, and nothing is in the way.
        let turned = |pose: &Isometry2<f64>| pose.rotation.angle() > FRAC_PI_4;
        let stopped = stopped_short(&Isometry2::identity(), FRAC_PI_2, 0.1, turned);
        let gap = FRAC_PI_4 - stopped.rotation.angle();
        assert!((0.0..2e-3).contains(&gap), "{gap}");
        assert!((stopped.translation.vector.norm() - 0.1).abs() < 1e-15);
    }
}
