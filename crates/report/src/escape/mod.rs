//! Pictures of the robot on its way out: Figures 4 to 7 of the paper, the moving obstacles that it
//! shows only in its videos, and a short animation.
//!
//! Every picture is a function from what was seen and done to an SVG file that needs nothing else,
//! on a light ground; the animation is a GIF.

use task::{Action, Image};

mod animation;
mod badges;
mod camera;
mod colour_scale;
mod colours;
mod drawing;
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

/// What was seen before a step, and what was done.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Where the robot was.
    pub pose: Pose,
    /// What stood around it.
    pub scene: Scene,
    /// What its camera saw.
    pub image: Image,
    /// The Q-values of the actions, from -135 to 135 degrees.
    pub values: [f32; Action::COUNT],
    /// The action taken.
    pub action: Action,
    /// Whether something stood in the way, and the robot stayed where it was.
    pub blocked: bool,
}

/// An episode: its steps, and where they led.
#[derive(Clone, Debug, PartialEq)]
pub struct Escape {
    /// One for each step, in their order.
    pub moments: Vec<Moment>,
    /// Where the robot was after the last step, and what stood around it then.
    pub last: (Pose, Scene),
    /// Whether it left the room.
    pub escaped: bool,
}

/// A step as a picture shows it.
#[derive(Clone, Copy, Debug)]
struct Step {
    from: Pose,
    to: Pose,
    /// The turn of the action, in radians counter-clockwise.
    turn: f64,
    blocked: bool,
}

impl Escape {
    /// The steps, in their order.
    fn steps(&self) -> impl ExactSizeIterator<Item = Step> {
        let next = |index: usize| self.moments.get(index + 1).map_or(self.last.0, |next| next.pose);
        self.moments.iter().enumerate().map(move |(index, moment)| Step {
            from: moment.pose,
            to: next(index),
            turn: f64::from(moment.action.turn_degrees()).to_radians(),
            blocked: moment.blocked,
        })
    }

    /// The scene before each step, and the last.
    fn scenes(&self) -> impl Iterator<Item = &Scene> {
        self.moments.iter().map(|moment| &moment.scene).chain([&self.last.1])
    }

    /// Where the robot began, and what stood around it.
    fn start(&self) -> (Pose, &Scene) {
        let first = self.moments.first().map(|moment| (moment.pose, &moment.scene));
        first.unwrap_or((self.last.0, &self.last.1))
    }

    /// How many moves were blocked.
    fn blocked(&self) -> usize {
        self.moments.iter().filter(|moment| moment.blocked).count()
    }

    /// The result in a few words, such as "14 steps, 2 blocked".
    fn words(&self) -> String {
        let (steps, blocked) = (self.moments.len(), self.blocked());
        let steps = format!("{steps} {}", if steps == 1 { "step" } else { "steps" });
        match blocked {
            _ if !self.escaped => format!("not out in {steps}"),
            0 => steps,
            _ => format!("{steps}, {blocked} blocked"),
        }
    }
}

/// Three moments of an escape that are worth a look: the first, one in the middle, and one shortly
/// before the end, when the exit does not yet fill the image. Fewer than three moments repeat; of
/// none, the indices are 0 and [`states`] shows nothing.
pub fn pick_states(escape: &Escape) -> [usize; 3] {
    let count = escape.moments.len();
    let late = if count > 3 { count - 2 } else { count.saturating_sub(1) };
    [0, late / 2, late]
}

#[cfg(test)]
mod fabricated;
#[cfg(test)]
mod tests;
