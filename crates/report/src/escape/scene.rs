//! The room and the objects in it, seen from above.
//!
//! Coordinates are metres in the frame `odom`, whose origin is the centre of the room. In a figure,
//! x points to the right and y up.

/// Side of the square floor of the room in metres.
pub const ROOM: f64 = 2.5;

/// Side of the square footprint of the robot in metres.
pub const ROBOT: f64 = 0.15;

/// The position and heading of the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// x coordinate in metres.
    pub x: f64,
    /// y coordinate in metres.
    pub y: f64,
    /// Heading in radians, counter-clockwise from the x axis.
    pub yaw: f64,
}

impl Pose {
    /// Returns the centre of the robot, `[x, y]` in metres.
    pub fn position(&self) -> [f64; 2] {
        [self.x, self.y]
    }

    /// Returns the point `[x, y]` at a distance of `metres` from the robot. `direction` is in
    /// radians, counter-clockwise from the heading.
    pub(super) fn ahead(&self, metres: f64, direction: f64) -> [f64; 2] {
        let (sine, cosine) = (self.yaw + direction).sin_cos();
        [self.x + metres * cosine, self.y + metres * sine]
    }
}

/// The outline of an object, or of a part of it, seen from above.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A cylinder.
    Circle {
        /// Centre, `[x, y]` in metres.
        centre: [f64; 2],
        /// Radius in metres.
        radius: f64,
    },
    /// A polygon with corners `[x, y]` in metres, clockwise or counter-clockwise.
    Polygon(Vec<[f64; 2]>),
}

impl Shape {
    /// Returns the centre, `[x, y]` in metres. For a polygon, this is the mean of its corners.
    pub(super) fn centre(&self) -> [f64; 2] {
        match self {
            Shape::Circle { centre, .. } => *centre,
            Shape::Polygon(corners) => {
                let count = corners.len().max(1) as f64;
                [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / count)
            }
        }
    }

    /// Returns the distance of a point from the shape in metres; negative inside a circle. For a
    /// polygon, this is the distance from the nearest corner or the centre, an approximation that
    /// is sufficient for small polygons.
    pub(super) fn distance(&self, point: [f64; 2]) -> f64 {
        match self {
            Shape::Circle { centre, radius } => distance(*centre, point) - radius,
            Shape::Polygon(corners) => {
                let points = corners.iter().copied().chain([self.centre()]);
                points.map(|corner| distance(corner, point)).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

/// The exit and the obstacles at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The shapes of the exit.
    pub exit: Vec<Shape>,
    /// The shapes of the obstacles. An obstacle may consist of several shapes. A moving obstacle
    /// has the same index in all scenes of an episode.
    pub obstacles: Vec<Shape>,
}

/// Returns the distance between two points.
pub(super) fn distance([x, y]: [f64; 2], [other_x, other_y]: [f64; 2]) -> f64 {
    (x - other_x).hypot(y - other_y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_to_the_left_is_counter_clockwise() {
        let pose = Pose { x: 1.0, y: 0.0, yaw: std::f64::consts::FRAC_PI_2 };
        assert!(distance(pose.ahead(0.5, 0.0), [1.0, 0.5]) < 1e-12);
        assert!(distance(pose.ahead(0.5, std::f64::consts::FRAC_PI_2), [0.5, 0.0]) < 1e-12);
    }

    #[test]
    fn distances_are_measured_from_the_edge() {
        let circle = Shape::Circle { centre: [1.0, 0.0], radius: 0.25 };
        assert_eq!(circle.distance([2.0, 0.0]), 0.75);
        let triangle = Shape::Polygon(vec![[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]);
        assert_eq!(triangle.centre(), [1.0, 1.0]);
        assert_eq!(triangle.distance([-2.0, 0.0]), 2.0);
        assert_eq!(Shape::Polygon(Vec::new()).centre(), [0.0, 0.0]);
    }
}
