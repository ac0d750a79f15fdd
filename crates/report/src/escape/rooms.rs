//! Ways out of different rooms: the paper's Figure 6.

use super::drawing::Drawing;
use super::{Escape, colours, plan, steps};

/// How many rooms stand side by side.
const COLUMNS: usize = 3;

/// The side of a room with its walls, the gap to the next, and the room for words, in pixels.
const SIDE: f64 = 276.0;
const GAP: f64 = 16.0;
const WORDS: f64 = 34.0;
const MARGIN: f64 = 20.0;

/// A grid of rooms from above as an SVG file, three in a row, each with one escape: an arrow for
/// each step that led somewhere, a cross for each that was blocked, a footprint at the start.
pub fn rooms(escapes: &[Escape]) -> String {
    let rows = escapes.len().div_ceil(COLUMNS).max(1) as f64;
    let height = 2.0 * MARGIN + rows * (SIDE + WORDS) - 8.0;
    let mut drawing = Drawing::new(900, height as u32);
    for (index, escape) in escapes.iter().enumerate() {
        let [column, row] = [index % COLUMNS, index / COLUMNS].map(|count| count as f64);
        let corner = (MARGIN + column * (SIDE + GAP), MARGIN + row * (SIDE + WORDS));
        let (start, scene) = escape.start();
        plan::room(&mut drawing, corner, SIDE, |drawing| {
            plan::scene(drawing, scene);
            plan::robot(drawing, start, colours::INK, 0.15);
            steps::path(drawing, escape.steps(), colours::INK, false);
        });
        let attributes = format!("font-size='13' text-anchor='middle' fill='{}'", colours::MUTED);
        drawing.text((corner.0 + SIDE / 2.0, corner.1 + SIDE + 19.0), &attributes, escape.words());
    }
    let words: Vec<_> = escapes.iter().map(Escape::words).collect();
    let description = format!(
        "{} rooms from above, each with a path of arrows from the robot's start: {}.",
        escapes.len(),
        words.join("; ")
    );
    drawing.finish("Paths out of random rooms", &description)
}
