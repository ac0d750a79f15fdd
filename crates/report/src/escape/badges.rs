//! Badges: letters beside the path that label sampled moments.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::colours::{INK, PAGE};
use super::drawing::Drawing;
use super::plan::{self, point};
use super::scene::{ROOM, distance};
use super::{Escape, Pose};

/// Labels of the sampled moments, in order.
pub(super) const LABELS: [&str; 3] = ["A", "B", "C"];

/// Radius of a badge in metres.
const RADIUS: f64 = 0.058;

/// Distance in metres between the centre of a badge and the centre of the robot. It keeps the badge
/// outside the footprint.
const DISTANCE: f64 = 0.175;

/// Draws the robot's footprint and a badge for each of three moments of the first escape. The badges
/// are as far as possible from the paths and the scene. Out-of-range indices in `moments` are ignored.
pub(super) fn badges(drawing: &mut Drawing, escapes: &[Escape], moments: [usize; 3]) {
    let Some(escape) = escapes.first() else { return };
    // Labels of the same moment share a badge.
    let mut labels = BTreeMap::<usize, String>::new();
    let count = escape.moments.len();
    for (label, moment) in LABELS.iter().zip(moments).filter(|(_, moment)| *moment < count) {
        *labels.entry(moment).or_default() += label;
    }
    let mut occupied: Vec<[f64; 2]> = escapes.iter().flat_map(path_points).collect();
    for (moment, label) in labels {
        let pose = escape.moments[moment].pose;
        let position = best_position(escape, pose, &occupied);
        // Keeps the next badges away from this one.
        occupied.push(position);
        plan::robot(drawing, pose, INK, 0.0);
        // Connects the footprint to the badge.
        let [from, to] = [midpoint(pose.position(), position), position].map(point);
        drawing.add(format_args!("<path d='M{from}L{to}' stroke='{INK}' stroke-width='6'/>"));
        badge(drawing, position, &label);
    }
}

/// Draws a badge with its centre at `position`, `[x, y]` in metres.
pub(super) fn badge(drawing: &mut Drawing, position: [f64; 2], label: &str) {
    let (at, radius) = (point(position), 1000.0 * RADIUS);
    drawing.add(format_args!(
        "<g class='badge' transform='translate({at})'>\
         <circle r='{radius:.0}' fill='{PAGE}' stroke='{INK}' stroke-width='8'/>\
         <text y='26' font-size='72' font-weight='700' text-anchor='middle'>{label}</text></g>"
    ));
}

/// Returns the positions of the robot along an escape and the midpoints of its steps.
fn path_points(escape: &Escape) -> Vec<[f64; 2]> {
    escape
        .steps()
        .map(|step| [step.from.position(), step.to.position()])
        .flat_map(|[from, to]| [from, midpoint(from, to)])
        .chain([escape.last.0.position()])
        .collect()
}

fn midpoint([x, y]: [f64; 2], [other_x, other_y]: [f64; 2]) -> [f64; 2] {
    [(x + other_x) / 2.0, (y + other_y) / 2.0]
}

/// Returns the position around a pose that is farthest from paths, shapes and walls.
fn best_position(escape: &Escape, pose: Pose, occupied: &[[f64; 2]]) -> [f64; 2] {
    let scene = escape.start().1;
    // A badge on the nose of the robot would hide its heading.
    let nose = pose.ahead(0.11, 0.0);
    let clearance = |position: [f64; 2]| {
        let paths = occupied.iter().chain([&nose]).map(|other| distance(*other, position));
        let shapes = scene.exit.iter().chain(&scene.obstacles);
        let shapes = shapes.map(|shape| shape.distance(position));
        let walls = position.map(|coordinate| ROOM / 2.0 - coordinate.abs());
        paths.chain(shapes).chain(walls).fold(f64::INFINITY, f64::min)
    };
    let positions = (0..24).map(|index| pose.ahead(DISTANCE, f64::from(index) / 24.0 * TAU));
    positions.max_by(|one, other| clearance(*one).total_cmp(&clearance(*other))).unwrap_or_default()
}
