//! Figures of escapes: versions of Figures 4 to 7 of the paper, a figure of an escape among moving
//! obstacles (shown only in the videos of the paper), and an animation.
//!
//! Each figure is a self-contained SVG file on a light background; the animation is a GIF.
//!
//! # Examples
//!
//! ```
//! use report::escape::{Escape, Moment, Pose, Scene, paths};
//! use task::{Action, Image};
//!
//! let moment = Moment {
//!     pose: Pose { x: 0.0, y: 1.0, yaw: 0.0 },
//!     scene: Scene::default(),
//!     image: Image::try_from(vec![128u8; Image::BYTES])?,
//!     values: [-1.0; Action::COUNT],
//!     action: Action::try_from(5)?,
//!     blocked: false,
//! };
//! let end = Pose { x: 0.0, y: 1.1524, yaw: 1.5708 };
//! let escape = Escape { moments: vec![moment], last: (end, Scene::default()), escaped: true };
//! assert!(paths(&[escape]).contains("1 step"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use task::{Action, Image};

mod animation;
mod badges;
mod camera;
mod colour_scale;
pub(super) mod colours;
pub(super) mod drawing;
mod legend;
mod palette;
mod paths;
mod plan;
mod preference;
mod rooms;
mod scene;
mod states;
mod steps;
mod trails;

pub use self::animation::animation;
pub use self::paths::paths;
pub use self::preference::TEMPERATURE;
pub use self::rooms::rooms;
pub use self::scene::{Pose, ROBOT, ROOM, Scene, Shape};
pub use self::states::states;
pub use self::trails::trails;

/// A step of an episode, with the state before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Pose of the robot before the step.
    pub pose: Pose,
    /// Exit and obstacles before the step.
    pub scene: Scene,
    /// Camera image before the step.
    pub image: Image,
    /// Q-values in the order of the action indices, from -135 to 135 degrees.
    pub values: [f32; Action::COUNT],
    /// The selected action.
    pub action: Action,
    /// Whether the move was blocked, so that the robot kept its pose.
    pub blocked: bool,
}

/// An episode, successful or not.
#[derive(Clone, Debug, PartialEq)]
pub struct Escape {
    /// The steps, in order.
    pub moments: Vec<Moment>,
    /// The pose of the robot and the scene after the last step.
    pub last: (Pose, Scene),
    /// Whether the robot reached the exit.
    pub escaped: bool,
}

/// A step as it is drawn.
#[derive(Clone, Copy, Debug)]
struct Step {
    from: Pose,
    to: Pose,
    /// Turn of the action in radians, counter-clockwise.
    turn: f64,
    blocked: bool,
}

impl Escape {
    /// Returns the steps, in order.
    fn steps(&self) -> impl ExactSizeIterator<Item = Step> {
        let next = |index: usize| self.moments.get(index + 1).map_or(self.last.0, |next| next.pose);
        self.moments.iter().enumerate().map(move |(index, moment)| Step {
            from: moment.pose,
            to: next(index),
            turn: f64::from(moment.action.turn_degrees()).to_radians(),
            blocked: moment.blocked,
        })
    }

    /// Returns the scene before each step and the scene after the last step.
    fn scenes(&self) -> impl Iterator<Item = &Scene> {
        self.moments.iter().map(|moment| &moment.scene).chain([&self.last.1])
    }

    /// Returns the pose of the robot and the scene at the start of the episode.
    fn start(&self) -> (Pose, &Scene) {
        let first = self.moments.first().map(|moment| (moment.pose, &moment.scene));
        first.unwrap_or((self.last.0, &self.last.1))
    }

    /// Returns the number of blocked moves.
    fn blocked(&self) -> usize {
        self.moments.iter().filter(|moment| moment.blocked).count()
    }

    /// Returns the result as a label, e.g. "14 steps, 2 blocked" or "failed after 200 steps".
    fn summary(&self) -> String {
        let (steps, blocked) = (self.moments.len(), self.blocked());
        let steps = format!("{steps} {}", if steps == 1 { "step" } else { "steps" });
        match blocked {
            _ if !self.escaped => format!("failed after {steps}"),
            0 => steps,
            _ => format!("{steps}, {blocked} blocked"),
        }
    }
}

/// Returns the indices of three representative moments of an escape: the first, one in the middle,
/// and one shortly before the end, when the exit does not yet fill the image.
///
/// If there are fewer than three moments, indices repeat. If there are none, all indices are
/// 0, and [`states`] ignores them.
pub fn sample_states(escape: &Escape) -> [usize; 3] {
    let count = escape.moments.len();
    let late = if count > 3 { count - 2 } else { count.saturating_sub(1) };
    [0, late / 2, late]
}

#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod tests;
