//! The concave wall: a semicircular dead end, in which the robot has to turn back.

use std::f64::consts::PI;

use nalgebra::{ComplexField, Point2};
use parry2d::math::Pose;
use parry2d::shape::{Compound, ConvexPolygon, SharedShape};

use super::contact;
use super::robot::Footprint;

/// Height of the concave wall in metres.
pub const CONCAVE_WALL_HEIGHT: f64 = 0.25;

/// Radius of the inner face in metres.
const INNER_RADIUS: f64 = 0.6;

/// Radius of the outer face in metres: the wall is 0.1 m thick.
const OUTER_RADIUS: f64 = 0.7;

/// The y coordinate of the centre of the arc in metres; x is 0. This centres the bounding box of
/// the wall in the room.
const CENTRE_Y: f64 = -OUTER_RADIUS / 2.0;

/// Number of straight segments of the arc. The chords deviate from the arc by at most 0.5 mm.
const SEGMENTS: usize = 48;

/// A semicircular wall in the middle of the room, open towards -y.
///
/// The inner diameter is 1.2 m, the thickness 0.1 m and the height [`CONCAVE_WALL_HEIGHT`].
#[derive(Debug, Clone)]
pub struct ConcaveWall {
    outline: Vec<Point2<f64>>,
    shape: Compound,
}

impl ConcaveWall {
    /// Creates the wall; its geometry is fixed.
    pub(crate) fn new() -> Self {
        let [inner, outer] = [INNER_RADIUS, OUTER_RADIUS].map(arc);
        let pieces = outer.windows(2).zip(inner.windows(2)).map(|(outer, inner)| {
            let corners = [outer[0], outer[1], inner[1], inner[0]];
            let corners = corners.iter().map(contact::point).collect();
            let piece = ConvexPolygon::from_convex_polyline(corners)
                .expect("a slice of a ring between two chords is convex");
            (Pose::identity(), SharedShape::new(piece))
        });
        let shape = Compound::new(pieces.collect());
        Self { outline: outline(), shape }
    }

    /// Returns the 98 corners of the ground plan in metres, clockwise: along the inner face from +x
    /// to -x, then back along the outer face.
    ///
    /// Segment `i` of the arc has the corners `i` and `i + 1` counted from the start, and `i` and
    /// `i + 1` counted from the end.
    pub fn outline(&self) -> &[Point2<f64>] {
        &self.outline
    }

    /// Returns whether the footprint touches the wall.
    pub(super) fn touches(&self, footprint: &Footprint) -> bool {
        footprint.touches(&Pose::identity(), &self.shape)
    }
}

/// Returns the outline of the wall (see [`ConcaveWall::outline`]), without its shape for contact
/// tests, which takes longer to create.
pub(crate) fn outline() -> Vec<Point2<f64>> {
    let [inner, outer] = [INNER_RADIUS, OUTER_RADIUS].map(arc);
    inner.into_iter().chain(outer.into_iter().rev()).collect()
}

/// Returns the corners of one face, counter-clockwise from +x to -x.
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
    fn the_bounding_box_is_centred_in_the_room() {
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
    fn the_outline_is_clockwise_and_has_the_area_of_half_a_ring() {
        let wall = ConcaveWall::new();
        let corners = wall.outline();
        let twice_the_area: f64 = (0..corners.len())
            .map(|corner| {
                let (from, to) = (corners[corner], corners[(corner + 1) % corners.len()]);
                from.x * to.y - from.y * to.x
            })
            .sum();
        // Half the area between two regular polygons with 96 corners.
        let polygon = |radius: f64| 48.0 * radius * radius * ComplexField::sin(PI / 48.0);
        let expected = (polygon(OUTER_RADIUS) - polygon(INNER_RADIUS)) / 2.0;
        assert!((twice_the_area / 2.0 + expected).abs() < 1e-12, "{twice_the_area}");
    }

    #[test]
    fn the_wall_is_solid_and_open_towards_negative_y() {
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
