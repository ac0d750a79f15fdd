//! Letters beside the path, where there is room for them.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::colours::{INK, PAGE};
use super::drawing::Drawing;
use super::plan::{self, point};
use super::scene::{ROOM, distance};
use super::{Escape, Pose};

/// The names of sampled moments, in their order.
pub(super) const NAMES: [&str; 3] = ["A", "B", "C"];

/// The radius of a badge in metres.
const RADIUS: f64 = 0.058;

/// Between the middles of a badge and of what it names, in metres: close, but off the footprint.
const NEAR: f64 = 0.175;

/// Draws the footprint and the name of three moments of the first escape, so that the names cover
/// as little as possible of the paths and the scene.
pub(super) fn badges(drawing: &mut Drawing, escapes: &[Escape], moments: [usize; 3]) {
    let Some(escape) = escapes.first() else { return };
    // Two names of one moment share its badge.
    let mut names = BTreeMap::<usize, String>::new();
    let count = escape.moments.len();
    for (name, moment) in NAMES.iter().zip(moments).filter(|(_, moment)| *moment < count) {
        *names.entry(moment).or_default() += name;
    }
    let mut taken: Vec<[f64; 2]> = escapes.iter().flat_map(trace).collect();
    for (moment, name) in names {
        let pose = escape.moments[moment].pose;
        let place = best_place(escape, pose, &taken);
        // A badge keeps its whole width from the next.
        taken.push(place);
        plan::robot(drawing, pose, INK, 0.0);
        // Between the footprint and the badge.
        let [from, to] = [halfway(pose.position(), place), place].map(point);
        drawing.add(format_args!("<path d='M{from}L{to}' stroke='{INK}' stroke-width='6'/>"));
        badge(drawing, place, &name);
    }
}

/// Draws a badge with its middle at a place in the room, `[x, y]` in metres.
pub(super) fn badge(drawing: &mut Drawing, place: [f64; 2], name: &str) {
    let (at, radius) = (point(place), 1000.0 * RADIUS);
    drawing.add(format_args!(
        "<g class='badge' transform='translate({at})'>\
         <circle r='{radius:.0}' fill='{PAGE}' stroke='{INK}' stroke-width='8'/>\
         <text y='26' font-size='72' font-weight='700' text-anchor='middle'>{name}</text></g>"
    ));
}

/// The middles of the robot along an escape, and those of its steps.
fn trace(escape: &Escape) -> Vec<[f64; 2]> {
    escape
        .steps()
        .map(|step| [step.from.position(), step.to.position()])
        .flat_map(|[from, to]| [from, halfway(from, to)])
        .chain([escape.last.0.position()])
        .collect()
}

fn halfway([x, y]: [f64; 2], [other_x, other_y]: [f64; 2]) -> [f64; 2] {
    [(x + other_x) / 2.0, (y + other_y) / 2.0]
}

/// Of the places around a pose, the one with the most room around it.
fn best_place(escape: &Escape, pose: Pose, taken: &[[f64; 2]]) -> [f64; 2] {
    let scene = escape.start().1;
    // The nose, where a badge would hide the heading.
    let nose = pose.ahead(0.11, 0.0);
    let room = |place: [f64; 2]| {
        let paths = taken.iter().chain([&nose]).map(|other| distance(*other, place));
        let shapes = scene.exit.iter().chain(&scene.obstacles).map(|shape| shape.distance(place));
        let walls = place.map(|coordinate| ROOM / 2.0 - coordinate.abs());
        paths.chain(shapes).chain(walls).fold(f64::INFINITY, f64::min)
    };
    let places = (0..24).map(|index| pose.ahead(NEAR, f64::from(index) / 24.0 * TAU));
    places.max_by(|one, other| room(*one).total_cmp(&room(*other))).unwrap_or_default()
}
