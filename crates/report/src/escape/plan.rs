//! The plan of the room: walls, exit, obstacles and robot, seen from above.

use std::fmt;

use super::colours::{EXIT, OBSTACLE, WALL};
use super::drawing::Drawing;
use super::scene::{Pose, ROBOT, ROOM, Scene, Shape};

/// Thickness of the drawn walls in millimetres.
const WALL_THICKNESS: f64 = 60.0;

/// Width of the border around the floor in millimetres: the exit extends 0.1 m into the wall.
const BORDER: f64 = 100.0;

/// A point of the plan in millimetres from the centre of the room; y points down.
#[derive(Clone, Copy)]
pub(super) struct Point(f64, f64);

impl fmt::Display for Point {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        // A tenth of a millimetre is less than a pixel. Adding zero turns -0 into 0.
        let [x, y] = [self.0, self.1].map(|length| (10.0 * length).round() / 10.0 + 0.0);
        write!(formatter, "{x} {y}")
    }
}

/// Converts a position in the room, `[x, y]` in metres, to a point of the plan.
pub(super) fn point([x, y]: [f64; 2]) -> Point {
    Point(1000.0 * x, -1000.0 * y)
}

/// Draws the empty room as a square of `side` pixels, including the walls, with its upper left
/// corner at `corner`. Then calls `draw`, which draws in the coordinates of [`Point`].
pub(super) fn room(
    drawing: &mut Drawing,
    corner: (f64, f64),
    side: f64,
    draw: impl FnOnce(&mut Drawing),
) {
    let floor = 1000.0 * ROOM;
    let scale = side / (floor + 2.0 * BORDER);
    let (x, y) = (corner.0 + side / 2.0, corner.1 + side / 2.0);
    let start = -(floor + WALL_THICKNESS) / 2.0;
    let length = floor + WALL_THICKNESS;
    let attributes = format_args!("transform='translate({x:.2} {y:.2}) scale({scale:.5})'");
    drawing.group(attributes, |drawing| {
        drawing.add(format_args!(
            "<rect x='{start}' y='{start}' width='{length}' height='{length}' fill='white' \
             stroke='{WALL}' stroke-width='{WALL_THICKNESS}'/>"
        ));
        draw(drawing);
    });
}

/// Draws the exit and the obstacles.
pub(super) fn scene(drawing: &mut Drawing, scene: &Scene) {
    shapes(drawing, &scene.exit, EXIT);
    shapes(drawing, &scene.obstacles, OBSTACLE);
}

/// Draws shapes in one colour, as a single SVG path. A thin outline covers the seams between
/// adjacent shapes.
pub(super) fn shapes(drawing: &mut Drawing, shapes: &[Shape], colour: &str) {
    if shapes.is_empty() {
        return;
    }
    let outlines: String = shapes.iter().map(outline).collect();
    drawing.add(format_args!(
        "<path d='{outlines}' fill='{colour}' stroke='{colour}' stroke-width='3' \
         stroke-linejoin='round'/>"
    ));
}

/// Returns the outline of a shape as SVG path data.
pub(super) fn outline(shape: &Shape) -> String {
    match shape {
        Shape::Circle { centre: [x, y], radius } => {
            let [left, right] = [point([x - radius, *y]), point([x + radius, *y])];
            let radius = 1000.0 * radius;
            format!(
                "M{left}A{radius:.1} {radius:.1} 0 1 1 {right}\
                 A{radius:.1} {radius:.1} 0 1 1 {left}Z"
            )
        }
        Shape::Polygon(corners) => {
            let corners: Vec<_> = corners.iter().map(|corner| point(*corner).to_string()).collect();
            if corners.is_empty() { String::new() } else { format!("M{}Z", corners.join("L")) }
        }
    }
}

/// Draws the footprint of the robot, with a nose that shows its heading. `opacity` (0 to 1)
/// applies only to the fill of the square.
pub(super) fn robot(drawing: &mut Drawing, pose: Pose, colour: &str, opacity: f64) {
    let side = 1000.0 * ROBOT;
    let corner = -side / 2.0;
    let (at, turn) = (point(pose.position()), -pose.yaw.to_degrees());
    drawing.add(format_args!(
        "<g class='robot' transform='translate({at}) rotate({turn:.2})'>\
         <rect x='{corner}' y='{corner}' width='{side}' height='{side}' rx='14' fill='{colour}' \
         fill-opacity='{opacity}' stroke='{colour}' stroke-width='9'/>\
         <path d='M75 -36L114 0L75 36Z' fill='{colour}'/></g>"
    ));
}
