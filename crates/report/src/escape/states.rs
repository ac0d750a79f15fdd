//! What the robot saw and what it would rather do: the middle and the right of the paper's Figures
//! 4, 5 and 7.

use task::Image;

use super::badges::NAMES;
use super::camera::camera;
use super::colour_scale::ColourScale;
use super::colours::{GRID, MUTED};
use super::drawing::Drawing;
use super::preference::{Compass, TEMPERATURE, full_ring};
use super::{Escape, Moment};

/// A pixel of an image, the gap between two states, and the radius of a compass, in pixels.
const PIXEL: f64 = 13.5;
const GAP: f64 = 25.0;
const RADIUS: f64 = 84.0;
const MARGIN: f64 = 20.0;

/// Three moments of an escape as an SVG file, named A, B and C: the camera's image, and beneath it
/// the preference for each action as a sector in the direction of its turn. The length of a sector
/// is its share in the softmax of the Q-values at the temperature [`TEMPERATURE`], its colour is the
/// Q-value, and a line surrounds the action that was taken. Moments that do not exist are left out.
pub fn states(escape: &Escape, indices: [usize; 3]) -> String {
    let mut drawing = Drawing::new(900, 476);
    let sampled: Vec<(&str, usize, &Moment)> = NAMES
        .into_iter()
        .zip(indices)
        .filter_map(|(name, index)| Some((name, index, escape.moments.get(index)?)))
        .collect();
    let values = || sampled.iter().map(|(_, _, moment)| &moment.values);
    let (scale, full) = (ColourScale::of(values().flatten()), full_ring(values()));
    let width = PIXEL * Image::WIDTH as f64;
    for (column, (name, index, moment)) in sampled.iter().enumerate() {
        let x = MARGIN + column as f64 * (width + GAP);
        drawing.text((x, 36.0), "font-size='17' font-weight='700'", name);
        let words = format!("step {} of {}", index + 1, escape.moments.len());
        drawing.text((x + 22.0, 36.0), &format!("fill='{MUTED}'"), words);
        camera(&mut drawing, &moment.image, (x, 48.0), PIXEL);
        view(&mut drawing, (x, 48.0 + PIXEL * Image::HEIGHT as f64), width);
        let centre = (x + width / 2.0, 287.0);
        let compass = Compass { centre, radius: RADIUS, full, scale };
        compass.draw(&mut drawing, &moment.values, moment.action);
        compass.label(&mut drawing, moment.action);
    }
    if !sampled.is_empty() {
        drawing.add(format_args!("<path d='M{MARGIN} 416H880' stroke='{GRID}'/>"));
        drawing.text((MARGIN, 443.0), "", "Colour: Q-value");
        scale.bar(&mut drawing, (150.0, 432.0), width - 130.0);
        let words =
            format!("Length: softmax at temperature {TEMPERATURE}. Outlined: the action taken");
        drawing.text((MARGIN + width + GAP, 443.0), "", words);
    }
    drawing.finish("Sampled states and what the robot prefers there", &description(&sampled))
}

/// Draws what the width of an image spans.
fn view(drawing: &mut Drawing, (x, y): (f64, f64), width: f64) {
    let ends = [(0.0, "start", "90°"), (0.5, "middle", "0°"), (1.0, "end", "−90°")];
    for (share, anchor, words) in ends {
        let attributes = format!("font-size='11' fill='{MUTED}' text-anchor='{anchor}'");
        drawing.text((x + share * width, y + 14.0), &attributes, words);
    }
}

fn description(sampled: &[(&str, usize, &Moment)]) -> String {
    let turns: Vec<_> = sampled
        .iter()
        .map(|(name, index, moment)| {
            let turn = moment.action.turn_degrees();
            format!("at {name}, step {}, it turns by {turn} degrees", index + 1)
        })
        .collect();
    format!(
        "Camera images, and the robot's preference for each of its seven turns: {}.",
        turns.join("; ")
    )
}
