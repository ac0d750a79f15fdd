//! A way out between obstacles that move, which the paper shows only in its videos.

use super::colours::{EXIT, INK, OBSTACLE, TRAIL};
use super::drawing::Drawing;
use super::legend::{Sign, legend};
use super::paths::{MARGIN, ROOM_SIDE};
use super::plan::{self, point};
use super::scene::Shape;
use super::{Escape, steps};

/// One escape from above as an SVG file, with the way that each obstacle went: pale at first, full
/// at last, as is the robot's path. Obstacles are drawn where they were in the end.
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

    let mut signs = vec![(Sign::Step(0), escape.words()), (Sign::Start, "start".to_owned())];
    if escape.blocked() > 0 {
        signs.push((Sign::Blocked, "blocked move".to_owned()));
    }
    signs.push((Sign::Trail, "way of an obstacle".to_owned()));
    signs.push((Sign::Nothing, "pale: early, full: late".to_owned()));
    legend(&mut drawing, &[signs, Sign::of_room()]);

    let description = format!(
        "The room from above, with the robot's path of arrows and the ways of {} moving obstacles, \
         both pale at first and full at last: {}.",
        last.obstacles.len(),
        escape.words()
    );
    drawing.finish("A path between moving obstacles", &description)
}

/// Draws where an obstacle was at each moment, its outline at the first, and itself, as if of
/// glass, at the last: the robot may have been there before.
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
        let opacity = steps::age(index + 1, centres.len() - 1);
        drawing.add(format_args!(
            "<path d='M{from}L{to}' stroke='{TRAIL}' stroke-width='22' \
             stroke-linecap='round' opacity='{opacity:.2}'/>"
        ));
    }
}
