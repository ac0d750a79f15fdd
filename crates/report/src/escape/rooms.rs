//! Escapes from different rooms, as in Figure 6 of the paper.

use super::drawing::Drawing;
use super::{Escape, colours, plan, steps};

/// Number of rooms per row.
const COLUMNS: usize = 3;

/// Side of a room, including its walls, in pixels.
const SIDE: f64 = 276.0;
/// Horizontal gap between two rooms in pixels.
const GAP: f64 = 16.0;
/// Height of the label below a room in pixels.
const LABEL_HEIGHT: f64 = 34.0;
/// Margin around all rooms in pixels.
const MARGIN: f64 = 20.0;

/// Returns an SVG file with one escape per room, seen from above, in rows of three rooms.
///
/// Arrows are steps, crosses are blocked moves, and a footprint marks the start.
pub fn rooms(escapes: &[Escape]) -> String {
    let rows = escapes.len().div_ceil(COLUMNS).max(1) as f64;
    let height = 2.0 * MARGIN + rows * (SIDE + LABEL_HEIGHT) - 8.0;
    let mut drawing = Drawing::new(900, height as u32);
    for (index, escape) in escapes.iter().enumerate() {
        let [column, row] = [index % COLUMNS, index / COLUMNS].map(|index| index as f64);
        let corner = (MARGIN + column * (SIDE + GAP), MARGIN + row * (SIDE + LABEL_HEIGHT));
        let (start, scene) = escape.start();
        plan::room(&mut drawing, corner, SIDE, |drawing| {
            plan::scene(drawing, scene);
            plan::robot(drawing, start, colours::INK, 0.15);
            steps::path(drawing, escape.steps(), colours::INK, false);
        });
        let attributes = format!("font-size='13' text-anchor='middle' fill='{}'", colours::MUTED);
        let at = (corner.0 + SIDE / 2.0, corner.1 + SIDE + 19.0);
        drawing.text(at, &attributes, escape.summary());
    }
    let summaries: Vec<_> = escapes.iter().map(Escape::summary).collect();
    let description = format!(
        "{} rooms from above, each with a path of arrows from the robot's start pose: {}.",
        escapes.len(),
        summaries.join("; ")
    );
    drawing.finish("Paths out of random rooms", &description)
}
