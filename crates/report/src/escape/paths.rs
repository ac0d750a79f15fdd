//! Escapes from the same room, as on the left of Figures 4, 5 and 7 of the paper.

use super::badges::badges;
use super::drawing::Drawing;
use super::legend::{Symbol, legend};
use super::scene::Scene;
use super::{Escape, colours, plan, sample_states, steps};

/// Side of the room, including its walls, in pixels.
pub(super) const ROOM_SIDE: f64 = 640.0;
/// Margin around the room in pixels.
pub(super) const MARGIN: f64 = 20.0;

/// Returns an SVG file with the paths of several escapes from the same room, seen from above.
///
/// Arrows are steps, crosses are blocked moves, and a footprint marks each start pose. The badges
/// A, B and C mark the moments of the first escape that [`sample_states`] selects for [`states`].
/// The exit and the obstacles are drawn as they are at the start of the first escape.
///
/// [`states`]: super::states()
pub fn paths(escapes: &[Escape]) -> String {
    let mut drawing = Drawing::new(900, 680);
    let empty = Scene::default();
    let scene = escapes.first().map_or(&empty, |escape| escape.start().1);
    plan::room(&mut drawing, (MARGIN, MARGIN), ROOM_SIDE, |drawing| {
        plan::scene(drawing, scene);
        for (index, escape) in escapes.iter().enumerate() {
            plan::robot(drawing, escape.start().0, colours::path(index), 0.15);
        }
        for (index, escape) in escapes.iter().enumerate() {
            steps::path(drawing, escape.steps(), colours::path(index), false);
        }
        if let Some(escape) = escapes.first() {
            badges(drawing, escapes, sample_states(escape));
        }
    });
    legend(&mut drawing, &entries(escapes, scene));

    let summaries: Vec<_> = escapes.iter().map(Escape::summary).collect();
    let description = format!(
        "The room from above, with a path of arrows for each of {} escapes: {}.",
        escapes.len(),
        summaries.join("; ")
    );
    drawing.finish("Paths out of the room", &description)
}

/// Returns the parts of the legend.
fn entries(escapes: &[Escape], scene: &Scene) -> Vec<Vec<(Symbol, String)>> {
    let paths = escapes.iter().enumerate();
    let paths = paths.map(|(index, escape)| (Symbol::Step(index), escape.summary()));
    let mut symbols = vec![(Symbol::Start, "start".to_owned())];
    if escapes.iter().any(|escape| escape.blocked() > 0) {
        symbols.push((Symbol::Blocked, "blocked move".to_owned()));
    }
    symbols.push((Symbol::Badge, "sampled state".to_owned()));
    vec![paths.collect(), symbols, Symbol::of_scene(scene)]
}
