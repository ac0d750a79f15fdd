//! Escapes for tests.

use task::{Action, Image};

use super::{Escape, Moment, Pose, Scene, Shape};

/// Returns an escape with `steps` steps straight up to the exit in the upper wall, and an
/// additional blocked move to the left before each step whose index is in `blocked`.
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

/// Returns an escape during which the cylinder moves to the right.
pub(super) fn escape_with_moving_cylinder(steps: usize) -> Escape {
    let mut escape = escape(steps, &[]);
    for (index, moment) in escape.moments.iter_mut().enumerate() {
        moment.scene = scene(0.025 * index as f64);
    }
    escape.last.1 = scene(0.025 * steps as f64);
    escape
}

/// Returns an episode without steps.
pub(super) fn empty_episode() -> Escape {
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

/// Returns a scene with an exit in the upper wall, a static triangle, and a cylinder that has moved
/// to the right by `moved` metres.
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
