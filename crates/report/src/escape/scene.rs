//! The room and what stands in it, seen from above.
//!
//! Lengths are metres in the frame `odom`, whose origin is the middle of the room. A picture has x
//! to the right and y up, as a map.

/// The sides of the room's floor, in metres.
pub const ROOM: f64 = 2.5;

/// The sides of the robot's footprint, in metres.
pub const ROBOT: f64 = 0.15;

/// Where a robot stands and where it looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Metres to the right.
    pub x: f64,
    /// Metres up.
    pub y: f64,
    /// Radians counter-clockwise from the x axis.
    pub yaw: f64,
}

impl Pose {
    /// The middle of the robot, `[x, y]` in metres.
    pub fn position(&self) -> [f64; 2] {
        [self.x, self.y]
    }

    /// The point so many metres away in a direction, in radians counter-clockwise from the heading.
    pub(super) fn ahead(&self, metres: f64, direction: f64) -> [f64; 2] {
        let (sine, cosine) = (self.yaw + direction).sin_cos();
        [self.x + metres * cosine, self.y + metres * sine]
    }
}

/// The ground plan of a thing, or of a piece of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A cylinder from above.
    Circle {
        /// `[x, y]` in metres.
        centre: [f64; 2],
        /// In metres.
        radius: f64,
    },
    /// The corners `[x, y]` in metres, either way round.
    Polygon(Vec<[f64; 2]>),
}

impl Shape {
    /// The middle: of a polygon, the mean of its corners.
    pub(super) fn centre(&self) -> [f64; 2] {
        match self {
            Shape::Circle { centre, .. } => *centre,
            Shape::Polygon(corners) => {
                let count = corners.len().max(1) as f64;
                [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / count)
            }
        }
    }

    /// How far a point is from the shape, in metres; of a polygon, from its corners and its middle,
    /// which will do for small ones.
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

/// What there is in the room at a moment, besides its walls and the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The ground plan of the exit.
    pub exit: Vec<Shape>,
    /// The ground plans of the obstacles. Many shapes may make up one obstacle; one that moves keeps
    /// its place in the list.
    pub obstacles: Vec<Shape>,
}

/// The distance between two points.
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
    fn distances_are_those_from_the_edge() {
        let circle = Shape::Circle { centre: [1.0, 0.0], radius: 0.25 };
        assert_eq!(circle.distance([2.0, 0.0]), 0.75);
        let triangle = Shape::Polygon(vec![[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]);
        assert_eq!(triangle.centre(), [1.0, 1.0]);
        assert_eq!(triangle.distance([-2.0, 0.0]), 2.0);
        assert_eq!(Shape::Polygon(Vec::new()).centre(), [0.0, 0.0]);
    }
}
