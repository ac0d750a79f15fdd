//! An escape among moving obstacles, which the paper shows only in its videos.

use super::colours::{EXIT, INK, OBSTACLE, TRAIL};
use super::drawing::Drawing;
use super::legend::{Symbol, legend};
use super::paths::{MARGIN, ROOM_SIDE};
use super::plan::{self, point};
use super::scene::Shape;
use super::{Escape, steps};

/// Returns an SVG file with one escape, seen from above, and the trail of each moving obstacle.
///
/// The opacity of the path and the trails increases with time. Obstacles are drawn at their final
/// positions.
pub fn trails(escape: &Escape) -> String {
    let mut drawing = Drawing::new(900, 680);
    let last = &escape.last.1;
    plan::room(&mut drawing, (MARGIN, MARGIN), ROOM_SIDE, |drawing| {
        plan::shapes(drawing, &last.exit, EXIT);
        for index in 0..last.obstacles.len() {
            let scenes = escape.scenes();
            let shapes: Vec<_> = scenes.filter_map(|scene| scene.obstacles.get(index)).collect();
            if shapes.iter().all(|shape| *shape == shapes[0]) {
                plan::shapes(drawing, &last.obstacles[index..=index], OBSTACLE);
            } else {
                trail(drawing, &shapes);
            }
        }
        plan::robot(drawing, escape.start().0, INK, 0.15);
        steps::path(drawing, escape.steps(), INK, true);
    });

    let mut symbols =
        vec![(Symbol::Step(0), escape.summary()), (Symbol::Start, "start".to_owned())];
    if escape.blocked() > 0 {
        symbols.push((Symbol::Blocked, "blocked move".to_owned()));
    }
    symbols.push((Symbol::Trail, "obstacle trail".to_owned()));
    symbols.push((Symbol::Nothing, "fainter: earlier".to_owned()));
    legend(&mut drawing, &[symbols, Symbol::of_room()]);

    let description = format!(
        "The room from above, with a path of arrows and the trails of {} moving obstacles, whose \
         opacity increases with time: {}.",
        last.obstacles.len(),
        escape.summary()
    );
    drawing.finish("A path among moving obstacles", &description)
}

/// Draws the trail of an obstacle. `shapes` holds the obstacle at each moment: the first is drawn
/// as an outline, the last as a translucent shape, because the path of the robot may cross it.
fn trail(drawing: &mut Drawing, shapes: &[&Shape]) {
    let [first, .., last] = shapes else { return };
    drawing.add(format_args!(
        "<g class='trail' fill='{OBSTACLE}' stroke='{OBSTACLE}' stroke-width='9'>\
         <path d='{}' fill='none' stroke-dasharray='26 20' opacity='0.6'/>\
         <path d='{}' fill-opacity='0.3'/></g>",
        plan::outline(first),
        plan::outline(last)
    ));
    let centres: Vec<_> = shapes.iter().map(|shape| shape.centre()).collect();
    for (index, pair) in centres.windows(2).enumerate() {
        let [from, to] = [point(pair[0]), point(pair[1])];
        let opacity = steps::opacity_at(index + 1, centres.len() - 1);
        drawing.add(format_args!(
            "<path d='M{from}L{to}' stroke='{TRAIL}' stroke-width='22' \
             stroke-linecap='round' opacity='{opacity:.2}'/>"
        ));
    }
}
