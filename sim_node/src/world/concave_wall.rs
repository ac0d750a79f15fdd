//! The concave wall: a half circle that a robot has to back out of.

use std::f64::consts::PI;

use nalgebra::{ComplexField, Point2};
use parry2d::math::Pose;
use parry2d::shape::{Compound, ConvexPolygon, SharedShape};

use super::contact;
use super::robot::Footprint;

/// The height of the concave wall, in metres.
pub const CONCAVE_WALL_HEIGHT: f64 = 0.25;

/// The radius of the arc's inner face, in metres.
const INNER_RADIUS: f64 = 0.6;

/// The radius of the arc's outer face, in metres: the wall is 0.1 m thick.
const OUTER_RADIUS: f64 = 0.7;

/// The arc's centre has this y and x = 0, which centres the wall's bounding box in the room.
const CENTRE_Y: f64 = -OUTER_RADIUS / 2.0;

/// How many straight pieces the arc is made of: so many that chord and arc are at most 0.5 mm
/// apart.
const SEGMENTS: usize = 48;

/// The half circle of wall in the middle of the room, open towards -y.
#[derive(Debug, Clone)]
pub struct ConcaveWall {
    outline: Vec<Point2<f64>>,
    shape: Compound,
}

impl ConcaveWall {
    /// The wall, which is always the same.
    pub(crate) fn new() -> Self {
        let (outer, inner) = (arc(OUTER_RADIUS), arc(INNER_RADIUS));
        let pieces = outer.windows(2).zip(inner.windows(2)).map(|(outer, inner)| {
            let corners = [outer[0], outer[1], inner[1], inner[0]];
            let corners = corners.iter().map(contact::point).collect();
            let piece = ConvexPolygon::from_convex_polyline(corners)
                .expect("a slice of a ring between two chords is convex");
            (Pose::identity(), SharedShape::new(piece))
        });
        let shape = Compound::new(pieces.collect());
        let outline = inner.into_iter().chain(outer.into_iter().rev()).collect();
        Self { outline, shape }
    }

    /// The corners of its ground plan, clockwise: along the inner face from +x to -x, then back
    /// along the outer face. A piece of the arc has the corners `i`, `i + 1`, and the same two
    /// counted from the end.
    pub fn outline(&self) -> &[Point2<f64>] {
        &self.outline
    }

    /// Whether the footprint reaches the wall.
    pub(super) fn touches(&self, footprint: &Footprint) -> bool {
        footprint.touches(&Pose::identity(), &self.shape)
    }
}

/// The corners of one face, counter-clockwise from +x to -x.
fn arc(radius: f64) -> Vec<Point2<f64>> {
    (0..=SEGMENTS)
        .map(|corner| {
            let angle = PI * corner as f64 / SEGMENTS as f64;
            let (sine, cosine) = ComplexField::sin_cos(angle);
            Point2::new(radius * cosine, CENTRE_Y + radius * sine)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry2, Vector2};

    use super::*;

    #[test]
    fn chords_are_within_half_a_millimetre_of_the_arc() {
        for radius in [INNER_RADIUS, OUTER_RADIUS] {
            for chord in arc(radius).windows(2) {
                let middle = nalgebra::center(&chord[0], &chord[1]);
                let error = radius - (middle - Point2::new(0.0, CENTRE_Y)).norm();
                assert!((0.0..=0.000_5).contains(&error), "{error} m");
            }
        }
    }

    #[test]
    fn its_bounding_box_is_centred_in_the_room() {
        let wall = ConcaveWall::new();
        let bounds = wall.shape.local_aabb();
        for (bound, expected) in [bounds.mins.x, bounds.mins.y, bounds.maxs.x, bounds.maxs.y]
            .into_iter()
            .zip([-0.7, -0.35, 0.7, 0.35])
        {
            assert!((bound - expected).abs() < 1e-6, "{bounds:?}");
        }
    }

    #[test]
    fn its_outline_is_clockwise_and_as_large_as_its_pieces() {
        let wall = ConcaveWall::new();
        let corners = wall.outline();
        let twice_the_area: f64 = (0..corners.len())
            .map(|corner| {
                let (from, to) = (corners[corner], corners[(corner + 1) % corners.len()]);
                from.x * to.y - from.y * to.x
            })
            .sum();
        // Half the ring between two regular polygons of 96 corners.
        let polygon = |radius: f64| 48.0 * radius * radius * ComplexField::sin(PI / 48.0);
        let expected = (polygon(OUTER_RADIUS) - polygon(INNER_RADIUS)) / 2.0;
        assert!((twice_the_area / 2.0 + expected).abs() < 1e-12, "{twice_the_area}");
    }

    #[test]
    fn is_solid_and_open_towards_negative_y() {
        let wall = ConcaveWall::new();
        for (x, y, expected) in [
            (0.0, 0.0, false),
            (0.0, -0.35, false),
            (0.0, -0.8, false),
            (0.0, 0.3, true),
            (0.0, 0.17, false),
            (0.0, 0.18, true),
            (0.0, 0.424, true),
            (0.0, 0.426, false),
            (0.65, -0.424, true),
            (0.65, -0.426, false),
            (-0.65, -0.3, true),
            (0.9, 0.9, false),
        ] {
            let footprint = Footprint::at(&Isometry2::new(Vector2::new(x, y), 0.0));
            assert_eq!(wall.touches(&footprint), expected, "({x}, {y})");
        }
    }
}
