//! Camera images and action preferences, as in the middle and on the right of Figures 4, 5 and 7 of
//! the paper.

use task::Image;

use super::badges::LABELS;
use super::camera::camera;
use super::colour_scale::ColourScale;
use super::colours::{GRID, MUTED};
use super::drawing::Drawing;
use super::preference::{PolarPlot, TEMPERATURE, full_ring};
use super::{Escape, Moment};

/// Size of a pixel of the camera image in pixels of the figure.
const PIXEL: f64 = 13.5;
/// Gap between two states in pixels.
const GAP: f64 = 25.0;
/// Radius of a polar plot in pixels.
const RADIUS: f64 = 84.0;
/// Margin of the figure in pixels.
const MARGIN: f64 = 20.0;

/// Returns an SVG file with three moments of an escape, labelled A, B and C: the camera image and,
/// below it, the preference for each action as a sector in the direction of its turn.
///
/// The length of a sector is the softmax of the Q-values at temperature [`TEMPERATURE`]; its
/// colour is the Q-value. The selected action is outlined. Out-of-range indices are ignored.
pub fn states(escape: &Escape, indices: [usize; 3]) -> String {
    let mut drawing = Drawing::new(900, 476);
    let sampled: Vec<(&str, usize, &Moment)> = LABELS
        .into_iter()
        .zip(indices)
        .filter_map(|(label, index)| Some((label, index, escape.moments.get(index)?)))
        .collect();
    let values = || sampled.iter().map(|(_, _, moment)| &moment.values);
    let (scale, full) = (ColourScale::of(values().flatten()), full_ring(values()));
    let width = PIXEL * Image::WIDTH as f64;
    for (column, (label, index, moment)) in sampled.iter().enumerate() {
        let x = MARGIN + column as f64 * (width + GAP);
        drawing.text((x, 36.0), "font-size='17' font-weight='700'", label);
        let step = format!("step {} of {}", index + 1, escape.moments.len());
        drawing.text((x + 22.0, 36.0), &format!("fill='{MUTED}'"), step);
        camera(&mut drawing, &moment.image, (x, 48.0), PIXEL);
        angle_labels(&mut drawing, (x, 48.0 + PIXEL * Image::HEIGHT as f64), width);
        let centre = (x + width / 2.0, 287.0);
        let plot = PolarPlot { centre, radius: RADIUS, full, scale };
        plot.draw(&mut drawing, &moment.values, moment.action);
        plot.label(&mut drawing, moment.action);
    }
    if !sampled.is_empty() {
        drawing.add(format_args!("<path d='M{MARGIN} 416H880' stroke='{GRID}'/>"));
        drawing.text((MARGIN, 443.0), "", "Colour: Q-value");
        scale.bar(&mut drawing, (150.0, 432.0), width - 130.0);
        let text =
            format!("Length: softmax at temperature {TEMPERATURE}. Outlined: selected action");
        drawing.text((MARGIN + width + GAP, 443.0), "", text);
    }
    drawing.finish("Sampled states and action preferences", &description(&sampled))
}

/// Labels the horizontal field of view below a camera image.
fn angle_labels(drawing: &mut Drawing, (x, y): (f64, f64), width: f64) {
    let ends = [(0.0, "start", "90°"), (0.5, "middle", "0°"), (1.0, "end", "−90°")];
    for (share, anchor, label) in ends {
        let attributes = format!("font-size='11' fill='{MUTED}' text-anchor='{anchor}'");
        drawing.text((x + share * width, y + 14.0), &attributes, label);
    }
}

fn description(sampled: &[(&str, usize, &Moment)]) -> String {
    let turns: Vec<_> = sampled
        .iter()
        .map(|(label, index, moment)| {
            format!("{} degrees at {label} (step {})", moment.action.turn_degrees(), index + 1)
        })
        .collect();
    format!(
        "Camera images, and the preference for each of the seven turns. Selected turns: {}.",
        turns.join("; ")
    )
}
