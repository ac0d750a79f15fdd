//! Paths on the plan of the room.

use super::colours::PAGE;
use super::drawing::Drawing;
use super::plan::point;
use super::{Pose, Step};

/// Draws the steps of a path: a cross for each blocked move, an arrow for any other. With `fade`,
/// the opacity increases from the first to the last step.
pub(super) fn path(
    drawing: &mut Drawing,
    steps: impl ExactSizeIterator<Item = Step>,
    colour: &str,
    fade: bool,
) {
    let count = steps.len();
    for (index, step) in steps.enumerate() {
        let opacity = if fade { opacity_at(index + 1, count) } else { 1.0 };
        if step.blocked {
            blocked(drawing, &step, colour, opacity);
        } else {
            arrow(drawing, step.from, step.to, colour, opacity);
        }
    }
}

/// Returns the opacity of the moment `index` in `0..=last`: 0.25 at 0, 1 at `last`.
pub(super) fn opacity_at(index: usize, last: usize) -> f64 {
    0.25 + 0.75 * index as f64 / last.max(1) as f64
}

/// Draws an arrow between two poses. Its head points along the heading of the second pose.
pub(super) fn arrow(drawing: &mut Drawing, from: Pose, to: Pose, colour: &str, opacity: f64) {
    let [from, tip] = [from, to].map(|pose| point(pose.position()));
    let [neck, left, right] = [(0.04, 0.0), (0.065, 0.47), (0.065, -0.47)]
        .map(|(metres, angle)| point(to.ahead(-metres, angle)));
    drawing.add(format_args!(
        "<path class='step' d='M{from}L{neck}M{tip}L{left}L{right}Z' fill='{colour}' \
         stroke='{colour}' stroke-width='13' stroke-linejoin='round' opacity='{opacity:.2}'/>"
    ));
}

/// Draws a cross in the direction of a blocked move, at the edge of the footprint.
fn blocked(drawing: &mut Drawing, step: &Step, colour: &str, opacity: f64) {
    let at = point(step.from.ahead(0.1, step.turn));
    drawing.add(format_args!(
        "<g class='blocked' transform='translate({at})' opacity='{opacity:.2}'>{}</g>",
        cross(colour)
    ));
}

/// Returns a cross around the origin. Its light border makes it visible on walls and obstacles.
pub(super) fn cross(colour: &str) -> String {
    let lines = "M-25 -25L25 25M25 -25L-25 25";
    format!(
        "<path d='{lines}' stroke='{PAGE}' stroke-width='34'/>\
         <path d='{lines}' stroke='{colour}' stroke-width='15'/>"
    )
}
