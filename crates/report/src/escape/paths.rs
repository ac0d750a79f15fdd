//! Several ways out of one room: the left of the paper's Figures 4, 5 and 7.

use super::badges::badges;
use super::drawing::Drawing;
use super::legend::{Sign, legend};
use super::scene::Scene;
use super::{Escape, colours, pick_states, plan, steps};

/// The side of the room with its walls, and the margin around it, in pixels.
pub(super) const ROOM_SIDE: f64 = 640.0;
pub(super) const MARGIN: f64 = 20.0;

/// The room of the first escape from above as an SVG file, with the paths of all of them: an arrow
/// for each step that led somewhere, a cross for each that was blocked, a footprint at the start.
/// A, B and C name the moments of the first escape that [`pick_states`] picks, for [`states`] to
/// show. The scene is that of the first escape's start, which the others share.
///
/// [`states`]: super::states()
pub fn paths(escapes: &[Escape]) -> String {
    let mut drawing = Drawing::new(900, 680);
    let nothing = Scene::default();
    let scene = escapes.first().map_or(&nothing, |escape| escape.start().1);
    plan::room(&mut drawing, (MARGIN, MARGIN), ROOM_SIDE, |drawing| {
        plan::scene(drawing, scene);
        for (index, escape) in escapes.iter().enumerate() {
            plan::robot(drawing, escape.start().0, colours::path(index), 0.15);
        }
        for (index, escape) in escapes.iter().enumerate() {
            steps::path(drawing, escape.steps(), colours::path(index), false);
        }
        if let Some(escape) = escapes.first() {
            badges(drawing, escapes, pick_states(escape));
        }
    });
    legend(&mut drawing, &entries(escapes, scene));

    let words: Vec<_> = escapes.iter().map(Escape::words).collect();
    let description = format!(
        "The room from above, with a path of arrows for each of {} escapes: {}.",
        escapes.len(),
        words.join("; ")
    );
    drawing.finish("Paths out of the room", &description)
}

fn entries(escapes: &[Escape], scene: &Scene) -> Vec<Vec<(Sign, String)>> {
    let paths = escapes.iter().enumerate();
    let paths = paths.map(|(index, escape)| (Sign::Step(index), escape.words()));
    let mut signs = vec![(Sign::Start, "start".to_owned())];
    if escapes.iter().any(|escape| escape.blocked() > 0) {
        signs.push((Sign::Blocked, "blocked move".to_owned()));
    }
    signs.push((Sign::Badge, "sampled state".to_owned()));
    vec![paths.collect(), signs, Sign::of_scene(scene)]
}
