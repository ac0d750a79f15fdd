//! Escapes made up for tests.

use task::{Action, Image};

use super::{Escape, Moment, Pose, Scene, Shape};

/// A straight way of so many steps up to the exit in the upper wall, with a step to the left before
/// each index in `blocked` that something keeps the robot from.
pub(super) fn escape(steps: usize, blocked: &[usize]) -> Escape {
    let up = std::f64::consts::FRAC_PI_2;
    let mut pose = Pose { x: 0.1, y: 1.1 - 0.1524 * steps as f64, yaw: up };
    let mut moments = Vec::new();
    for index in 0..steps {
        if blocked.contains(&index) {
            moments.push(moment(pose, 5, true));
        }
        moments.push(moment(pose, 3, false));
        pose.y += 0.1524;
    }
    Escape { moments, last: (pose, scene(0.0)), escaped: true }
}

/// An escape on which the obstacle moves to the right.
pub(super) fn between_moving_obstacles(steps: usize) -> Escape {
    let mut escape = escape(steps, &[]);
    for (index, moment) in escape.moments.iter_mut().enumerate() {
        moment.scene = scene(0.025 * index as f64);
    }
    escape.last.1 = scene(0.025 * steps as f64);
    escape
}

/// An episode that was over before it began.
pub(super) fn nothing() -> Escape {
    Escape { moments: Vec::new(), last: (Pose::default(), Scene::default()), escaped: false }
}

fn moment(pose: Pose, action: u8, blocked: bool) -> Moment {
    let bytes: Vec<u8> = (0..Image::BYTES).map(|index| (index / 60 * 30) as u8).collect();
    let mut values = [-1.5, -1.4, -1.3, -1.2, -1.3, -1.4, -1.5];
    values[usize::from(action)] = -1.1;
    Moment {
        pose,
        scene: scene(0.0),
        image: Image::try_from(&bytes[..]).unwrap(),
        values,
        action: Action::try_from(action).unwrap(),
        blocked,
    }
}

/// An exit in the upper wall, a cylinder so many metres to the right of its first place, and a
/// triangle that stands still.
fn scene(moved: f64) -> Scene {
    let exit = vec![[-0.25, 1.15], [0.25, 1.15], [0.25, 1.35], [-0.25, 1.35]];
    let triangle = vec![[-0.9, -0.9], [-0.6, -0.9], [-0.9, -0.6]];
    Scene {
        exit: vec![Shape::Polygon(exit)],
        obstacles: vec![
            Shape::Circle { centre: [-0.6 + moved, 0.2], radius: 0.1524 },
            Shape::Polygon(triangle),
        ],
    }
}
