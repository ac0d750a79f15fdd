//! The legend of a figure.

use super::colours::{self, EXIT, INK, MUTED, OBSTACLE, TRAIL, WALL};
use super::drawing::Drawing;
use super::scene::{Pose, Scene};
use super::{badges, plan, steps};

/// A symbol on the plan.
#[derive(Clone, Copy)]
pub(super) enum Symbol {
    /// A step of the path with this index.
    Step(usize),
    Start,
    Blocked,
    Badge,
    Trail,
    Wall,
    Exit,
    Obstacle,
    /// No symbol, only a label.
    Nothing,
}

impl Symbol {
    /// Returns the symbols for an empty room, with their labels.
    pub fn of_room() -> Vec<(Symbol, String)> {
        vec![(Symbol::Exit, "exit".to_owned()), (Symbol::Wall, "wall".to_owned())]
    }

    /// Returns the symbols for a room and its scene, with their labels.
    pub fn of_scene(scene: &Scene) -> Vec<(Symbol, String)> {
        let mut symbols = Symbol::of_room();
        if !scene.obstacles.is_empty() {
            symbols.push((Symbol::Obstacle, "obstacle".to_owned()));
        }
        symbols
    }
}

/// x coordinate of the left end of the labels in pixels, for a figure 900 pixels wide.
const LABEL_X: f64 = 726.0;
/// x coordinate of the centre of the symbols in pixels.
const SYMBOL_X: f64 = 697.0;

/// Distance between two lines in pixels.
const LINE_HEIGHT: f64 = 32.0;

/// Draws a legend to the right of a room, with half a line of space between its parts.
pub(super) fn legend(drawing: &mut Drawing, parts: &[Vec<(Symbol, String)>]) {
    let mut y = 46.0;
    for part in parts.iter().filter(|part| !part.is_empty()) {
        for (symbol, label) in part {
            // The symbols are slightly smaller than on the plan.
            let attributes = format_args!("transform='translate({SYMBOL_X} {y}) scale(0.19)'");
            drawing.group(attributes, |drawing| draw(drawing, *symbol));
            drawing.text((LABEL_X, y + 5.0), "", label);
            y += LINE_HEIGHT;
        }
        y += LINE_HEIGHT / 2.0;
    }
}

/// Draws a symbol centred at the origin, in the units of the plan (millimetres).
fn draw(drawing: &mut Drawing, symbol: Symbol) {
    let swatch = |drawing: &mut Drawing, colour| {
        drawing
            .add(format_args!("<rect x='-90' y='-42' width='180' height='84' fill='{colour}'/>"));
    };
    match symbol {
        Symbol::Step(index) => {
            let [from, to] = [-0.09, 0.09].map(|x| Pose { x, ..Pose::default() });
            steps::arrow(drawing, from, to, colours::path(index), 1.0);
        }
        Symbol::Start => plan::robot(drawing, Pose::default(), MUTED, 0.15),
        Symbol::Blocked => drawing.add(format_args!("{}", steps::cross(INK))),
        Symbol::Badge => badges::badge(drawing, [0.0, 0.0], "A"),
        Symbol::Trail => drawing.add(format_args!(
            "<g stroke='{OBSTACLE}' stroke-width='10'>\
             <circle cx='-58' r='44' fill='none' stroke-dasharray='24 16'/>\
             <circle cx='58' r='44' fill='{OBSTACLE}' fill-opacity='0.3'/>\
             <path d='M-58 0H58' stroke='{TRAIL}' stroke-width='22' stroke-linecap='round'/></g>"
        )),
        Symbol::Wall => swatch(drawing, WALL),
        Symbol::Exit => swatch(drawing, EXIT),
        Symbol::Obstacle => swatch(drawing, OBSTACLE),
        Symbol::Nothing => {}
    }
}
