//! Rendering: the nearest upright face for each ray.

use nalgebra::{Isometry2, Point2, Translation2, Vector2};

use super::frame::{CHANNELS, Frame, PIXELS};
use super::light::{self, Colour, Light};
use super::ray_fan::{Ray, RayFan};
use super::settings::{CameraSettings, CameraSettingsError};
use crate::world::{
    CONCAVE_WALL_HEIGHT, CYLINDER_HEIGHT, CYLINDER_RADIUS, ConcaveWall, Cylinder, EXIT_DEPTH,
    EXIT_HEIGHT, EXIT_WIDTH, Exit, ROOM_SIDE, WALL_HEIGHT, World,
};

/// A camera on the robot.
#[derive(Debug, Clone)]
pub struct Camera {
    settings: CameraSettings,
    fan: RayFan,
    light: Light,
    /// What the rays meet where nothing stands: the floor, or nothing.
    background: [Hit; PIXELS],
    walls: Vec<Face>,
    concave_wall: Vec<Face>,
}

/// What a ray meets first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    /// From the eye, in metres; infinite for the sky.
    pub(super) distance: f64,
    colour: [u8; CHANNELS],
}

impl Camera {
    /// A camera with this mount.
    ///
    /// # Errors
    ///
    /// If the camera would not be on the robot, or could see an obstacle's top.
    pub fn new(settings: CameraSettings) -> Result<Self, CameraSettingsError> {
        settings.check()?;
        let light = Light::new();
        let fan = RayFan::new(settings.pitch);
        let (floor, sky) = (light::bytes(light::FLOOR), light::bytes(light::SKY));
        let background = fan.rays().map(|ray| {
            if ray.direction.z < 0.0 {
                Hit { distance: -settings.height / ray.direction.z, colour: floor }
            } else {
                Hit { distance: f64::INFINITY, colour: sky }
            }
        });
        // The room's outline is counter-clockwise, because the wall is outside.
        const HALF: f64 = ROOM_SIDE / 2.0;
        let room = [(HALF, -HALF), (HALF, HALF), (-HALF, HALF), (-HALF, -HALF)];
        let room = room.map(|(x, y)| Point2::new(x, y));
        let walls = faces(&room, WALL_HEIGHT, light::WALL, light).collect();
        let concave_wall = ConcaveWall::new();
        let concave_wall =
            faces(concave_wall.outline(), CONCAVE_WALL_HEIGHT, light::OBSTACLE, light).collect();
        Ok(Self { settings, fan, light, background, walls, concave_wall })
    }

    /// The mount.
    pub fn settings(&self) -> &CameraSettings {
        &self.settings
    }

    /// What the camera sees now.
    ///
    /// A robot that has escaped may have its camera inside the exit, or inside the wall behind it.
    /// It then sees nothing but the colour of what is around it, which no light reaches.
    pub fn render(&self, world: &World) -> Frame {
        let mut frame = Frame::default();
        self.render_to(world, frame.bytes_mut());
        frame
    }

    /// As [`render`](Self::render), into the bytes of a frame that lie somewhere else: in a message.
    pub fn render_to(&self, world: &World, bytes: &mut [u8; Frame::LENGTH]) {
        let pixels = bytes.as_chunks_mut::<CHANNELS>().0;
        let eye = self.eye(world);
        if let Some(colour) = surrounding(&eye.translation.vector.into(), world) {
            return pixels.fill(light::in_the_dark(colour));
        }
        for (ray, hit) in self.rays().iter().zip(self.cast(&eye, world)) {
            pixels[ray.pixel] = hit.colour;
        }
    }

    /// The rays, in the order of [`Camera::cast`].
    pub(crate) fn rays(&self) -> &[Ray; PIXELS] {
        self.fan.rays()
    }

    /// The pose of the eye in the ground plan.
    pub(crate) fn eye(&self, world: &World) -> Isometry2<f64> {
        world.robot() * Translation2::new(self.settings.forward, self.settings.left)
    }

    /// What each ray of the fan meets first, for an eye that no solid surrounds.
    pub(super) fn cast(&self, eye: &Isometry2<f64>, world: &World) -> [Hit; PIXELS] {
        let mut hits = self.background;
        for face in &self.walls {
            self.cast_at_face(face, eye, &mut hits);
        }
        for face in faces(&exit_outline(world.exit()), EXIT_HEIGHT, light::EXIT, self.light) {
            self.cast_at_face(&face, eye, &mut hits);
        }
        if world.concave_wall().is_some() {
            for face in &self.concave_wall {
                self.cast_at_face(face, eye, &mut hits);
            }
        }
        let light = self.light.seen_from(&eye.rotation);
        for cylinder in world.cylinders() {
            self.cast_at_cylinder(cylinder, eye, &light, &mut hits);
        }
        hits
    }

    fn cast_at_face(&self, face: &Face, eye: &Isometry2<f64>, hits: &mut [Hit; PIXELS]) {
        let (from, to) = (face.from - eye.translation.vector, face.to - eye.translation.vector);
        // Twice the area of the triangle between the eye and the face.
        let area = from.coords.perp(&to.coords);
        if area <= 0.0 {
            return; // Seen from behind.
        }
        let from = eye.rotation.inverse_transform_point(&from).coords;
        let to = eye.rotation.inverse_transform_point(&to).coords;
        let along = to - from;
        for index in self.fan.between(&from, &to) {
            let direction = &self.rays()[index].direction;
            let distance = area / direction.xy().perp(&along);
            if self.is_seen(index, distance, face.height, hits) {
                hits[index] = Hit { distance, colour: face.colour };
            }
        }
    }

    fn cast_at_cylinder(
        &self,
        cylinder: &Cylinder,
        eye: &Isometry2<f64>,
        light: &Light,
        hits: &mut [Hit; PIXELS],
    ) {
        let centre = eye.inverse_transform_point(&cylinder.centre()).coords;
        // The square of the length of a tangent from the eye, which is never inside: the robot
        // does not touch cylinders.
        let tangent = centre.norm_squared() - CYLINDER_RADIUS * CYLINDER_RADIUS;
        let middle = centre * tangent.sqrt();
        let aside = Vector2::new(-centre.y, centre.x) * CYLINDER_RADIUS;
        for index in self.fan.between(&(middle - aside), &(middle + aside)) {
            let direction = self.rays()[index].direction.xy();
            let square = direction.norm_squared();
            let middle = direction.dot(&centre);
            // Between the tangents; less than 0 only by rounding.
            let half_chord = (middle * middle - square * tangent).max(0.0).sqrt();
            let distance = (middle - half_chord) / square;
            if self.is_seen(index, distance, CYLINDER_HEIGHT, hits) {
                let normal = (direction * distance - centre) / CYLINDER_RADIUS;
                let colour = light.shade(light::OBSTACLE, &normal);
                hits[index] = Hit { distance, colour };
            }
        }
    }

    /// Whether a ray that gets to an upright face of this height at this distance meets it there:
    /// the ray does not pass over it, and has met nothing before.
    fn is_seen(&self, index: usize, distance: f64, height: f64, hits: &[Hit; PIXELS]) -> bool {
        let rise = distance * self.rays()[index].direction.z;
        distance > 0.0 && distance < hits[index].distance && self.settings.height + rise <= height
    }
}

/// An upright face, seen from the side that has it run from right to left: the solid is on the
/// right of the way from `from` to `to`.
#[derive(Debug, Clone, Copy)]
struct Face {
    from: Point2<f64>,
    to: Point2<f64>,
    height: f64,
    colour: [u8; CHANNELS],
}

/// The faces of a prism, from its outline: clockwise around a solid, counter-clockwise around a
/// hollow.
fn faces(
    outline: &[Point2<f64>],
    height: f64,
    colour: Colour,
    light: Light,
) -> impl Iterator<Item = Face> {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(move |(&from, &to)| {
        let along = (to - from).normalize();
        let normal = Vector2::new(-along.y, along.x);
        Face { from, to, height, colour: light.shade(colour, &normal) }
    })
}

/// The corners of the exit's ground plan, clockwise.
fn exit_outline(exit: &Exit) -> [Point2<f64>; 4] {
    const X: f64 = EXIT_DEPTH / 2.0;
    const Y: f64 = EXIT_WIDTH / 2.0;
    [(X, Y), (X, -Y), (-X, -Y), (-X, Y)].map(|(x, y)| exit.pose() * Point2::new(x, y))
}

/// The colour of the solid around a point, if there is one: the exit before the wall that it
/// stands in. The robot touches no other solid.
fn surrounding(point: &Point2<f64>, world: &World) -> Option<Colour> {
    let from_exit = world.exit().pose().inverse_transform_point(point);
    if from_exit.x.abs() <= EXIT_DEPTH / 2.0 && from_exit.y.abs() <= EXIT_WIDTH / 2.0 {
        Some(light::EXIT)
    } else if point.x.abs() >= ROOM_SIDE / 2.0 || point.y.abs() >= ROOM_SIDE / 2.0 {
        Some(light::WALL)
    } else {
        None
    }
}
