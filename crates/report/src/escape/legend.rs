//! What the signs of a picture mean.

use super::colours::{self, EXIT, INK, MUTED, OBSTACLE, TRAIL, WALL};
use super::drawing::Drawing;
use super::scene::{Pose, Scene};
use super::{badges, plan, steps};

/// A sign, as it is drawn on a plan.
#[derive(Clone, Copy)]
pub(super) enum Sign {
    /// A step of the path of this index.
    Step(usize),
    Start,
    Blocked,
    Badge,
    Trail,
    Wall,
    Exit,
    Obstacle,
    /// Words alone.
    Nothing,
}

impl Sign {
    /// The signs of an empty room, and their words.
    pub fn of_room() -> Vec<(Sign, String)> {
        vec![(Sign::Exit, "exit".to_owned()), (Sign::Wall, "wall".to_owned())]
    }

    /// The signs of a room and what is in it, and their words.
    pub fn of_scene(scene: &Scene) -> Vec<(Sign, String)> {
        let mut signs = Sign::of_room();
        if !scene.obstacles.is_empty() {
            signs.push((Sign::Obstacle, "obstacle".to_owned()));
        }
        signs
    }
}

/// Where the words begin on a page of 900 pixels, and the signs' middles.
const WORDS: f64 = 726.0;
const SIGNS: f64 = 697.0;

/// From one line to the next, in pixels.
const LINE: f64 = 32.0;

/// Writes a legend to the right of a room; some room is left between its parts.
pub(super) fn legend(drawing: &mut Drawing, parts: &[Vec<(Sign, String)>]) {
    let mut y = 46.0;
    for part in parts.iter().filter(|part| !part.is_empty()) {
        for (sign, words) in part {
            // A little smaller than on the plan.
            let attributes = format_args!("transform='translate({SIGNS} {y}) scale(0.19)'");
            drawing.group(attributes, |drawing| draw(drawing, *sign));
            drawing.text((WORDS, y + 5.0), "", words);
            y += LINE;
        }
        y += LINE / 2.0;
    }
}

/// Draws a sign around the origin, in millimetres of the plan.
fn draw(drawing: &mut Drawing, sign: Sign) {
    let swatch = |drawing: &mut Drawing, colour| {
        drawing
            .add(format_args!("<rect x='-90' y='-42' width='180' height='84' fill='{colour}'/>"));
    };
    match sign {
        Sign::Step(index) => {
            let [from, to] = [-0.09, 0.09].map(|x| Pose { x, ..Pose::default() });
            steps::arrow(drawing, from, to, colours::path(index), 1.0);
        }
        Sign::Start => plan::robot(drawing, Pose::default(), MUTED, 0.15),
        Sign::Blocked => drawing.add(format_args!("{}", steps::cross(INK))),
        Sign::Badge => badges::badge(drawing, [0.0, 0.0], "A"),
        Sign::Trail => drawing.add(format_args!(
            "<g stroke='{OBSTACLE}' stroke-width='10'>\
             <circle cx='-58' r='44' fill='none' stroke-dasharray='24 16'/>\
             <circle cx='58' r='44' fill='{OBSTACLE}' fill-opacity='0.3'/>\
             <path d='M-58 0H58' stroke='{TRAIL}' stroke-width='22' stroke-linecap='round'/></g>"
        )),
        Sign::Wall => swatch(drawing, WALL),
        Sign::Exit => swatch(drawing, EXIT),
        Sign::Obstacle => swatch(drawing, OBSTACLE),
        Sign::Nothing => {}
    }
}
