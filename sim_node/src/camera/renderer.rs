//! Rendering: finds the nearest vertical face for each ray.

use nalgebra::{Isometry2, Point2, Rotation3, Translation2, Vector2, Vector3};

use super::frame::{CHANNELS, Frame, PIXELS};
use super::light::{self, Colour, Light, Palette};
use super::ray_fan::{Ray, RayFan};
use super::settings::{CameraSettings, CameraSettingsError};
use crate::reality::Conditions;
use crate::world::{
    CONCAVE_WALL_HEIGHT, CYLINDER_HEIGHT, CYLINDER_RADIUS, Cylinder, EXIT_DEPTH, EXIT_HEIGHT,
    EXIT_WIDTH, Exit, ROOM_SIDE, WALL_HEIGHT, World, concave_wall,
};

/// Lowest height above the floor in metres, whatever the error of the mount.
const LOWEST: f64 = 0.001;
/// Greatest height, just below the top of the lowest obstacle.
const HIGHEST: f64 = CONCAVE_WALL_HEIGHT - 0.001;

/// The camera on the robot.
#[derive(Debug, Clone)]
pub struct Camera {
    settings: CameraSettings,
    /// The conditions for which the fields below are computed.
    conditions: Conditions,
    fan: RayFan,
    /// Height above the floor in metres.
    height: f64,
    light: Light,
    palette: Palette,
    /// What each ray hits in an empty world: the floor or the sky.
    background: [Hit; PIXELS],
    walls: Vec<Face>,
    concave_wall: Vec<Face>,
}

/// The nearest hit of a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    /// Distance from the eye along the ray in metres; infinite for the sky.
    pub(super) distance: f64,
    colour: [u8; CHANNELS],
}

impl Camera {
    /// Creates a camera with this mount, in the world of the paper.
    ///
    /// # Errors
    ///
    /// Returns an error if a setting is outside the range documented in [`CameraSettings`].
    pub fn new(settings: CameraSettings) -> Result<Self, CameraSettingsError> {
        settings.check()?;
        Ok(Self::under(settings, Conditions::default()))
    }

    /// Adapts the camera to the conditions of an episode. Must be called after each reset of the
    /// world.
    pub fn adapt(&mut self, conditions: &Conditions) {
        if self.conditions != *conditions {
            *self = Self::under(self.settings, conditions.clone());
        }
    }

    fn under(settings: CameraSettings, conditions: Conditions) -> Self {
        let error = &conditions.camera;
        let axes = [
            (Vector3::z_axis(), error.yaw),
            (Vector3::y_axis(), settings.pitch + error.pitch),
            (Vector3::x_axis(), error.roll),
        ];
        let rotations = axes.map(|(axis, angle)| Rotation3::from_axis_angle(&axis, angle));
        let mount = rotations.into_iter().fold(Rotation3::identity(), |mount, turn| mount * turn);
        let fan = RayFan::new(&mount, error.lens);
        let height = match error.height == 0.0 {
            true => settings.height,
            false => (settings.height + error.height).clamp(LOWEST, HIGHEST),
        };
        let light = Light::new(&conditions.light);
        let palette = Palette::new(&conditions.surfaces);
        let (floor, sky) = (light::bytes(palette.floor), light::bytes(palette.sky));
        let background = fan.rays().map(|ray| {
            if ray.direction.z < 0.0 {
                Hit { distance: -height / ray.direction.z, colour: floor }
            } else {
                Hit { distance: f64::INFINITY, colour: sky }
            }
        });
        // Counter-clockwise, because the walls are outside this outline.
        const HALF: f64 = ROOM_SIDE / 2.0;
        let room = [(HALF, -HALF), (HALF, HALF), (-HALF, HALF), (-HALF, -HALF)];
        let room = room.map(|(x, y)| Point2::new(x, y));
        let walls = faces(&room, WALL_HEIGHT, palette.wall, light).collect();
        let outline = concave_wall::outline();
        let concave_wall = faces(&outline, CONCAVE_WALL_HEIGHT, palette.obstacle, light).collect();
        Self { settings, conditions, fan, height, light, palette, background, walls, concave_wall }
    }

    /// Returns the mount.
    pub fn settings(&self) -> &CameraSettings {
        &self.settings
    }

    /// Renders what the camera sees now.
    ///
    /// After an escape the camera may be inside the exit or inside the wall behind it. The frame
    /// then has the colour of that object in ambient light only.
    pub fn render(&self, world: &World) -> Frame {
        let mut frame = Frame::default();
        self.render_to(world, frame.bytes_mut());
        frame
    }

    /// Renders into an existing buffer, for example that of a message. The layout is the same as
    /// in [`Frame`].
    pub fn render_to(&self, world: &World, bytes: &mut [u8; Frame::LENGTH]) {
        let pixels = bytes.as_chunks_mut::<CHANNELS>().0;
        let eye = self.eye(world);
        if let Some(colour) = self.enclosing_colour(&eye.translation.vector.into(), world) {
            return pixels.fill(light::ambient(colour));
        }
        for (ray, hit) in self.rays().iter().zip(self.cast(&eye, world)) {
            pixels[ray.pixel] = hit.colour;
        }
    }

    /// Returns the rays, in the order of [`Camera::cast`].
    pub(crate) fn rays(&self) -> &[Ray; PIXELS] {
        self.fan.rays()
    }

    /// Returns the pose of the eye in the ground plan; its heading is that of the robot.
    pub(crate) fn eye(&self, world: &World) -> Isometry2<f64> {
        world.robot() * Translation2::new(self.settings.forward, self.settings.left)
    }

    /// Returns the nearest hit of each ray. The eye must not be inside a solid.
    pub(super) fn cast(&self, eye: &Isometry2<f64>, world: &World) -> [Hit; PIXELS] {
        let mut hits = self.background;
        for face in &self.walls {
            self.cast_at_face(face, eye, &mut hits);
        }
        for face in faces(&exit_outline(world.exit()), EXIT_HEIGHT, self.palette.exit, self.light) {
            self.cast_at_face(&face, eye, &mut hits);
        }
        if world.concave_wall().is_some() {
            for face in &self.concave_wall {
                self.cast_at_face(face, eye, &mut hits);
            }
        }
        let light = self.light.in_frame(&eye.rotation);
        for cylinder in world.cylinders() {
            self.cast_at_cylinder(cylinder, eye, &light, &mut hits);
        }
        hits
    }

    fn cast_at_face(&self, face: &Face, eye: &Isometry2<f64>, hits: &mut [Hit; PIXELS]) {
        let (from, to) = (face.from - eye.translation.vector, face.to - eye.translation.vector);
        // Twice the area of the triangle formed by the eye and the face.
        let area = from.coords.perp(&to.coords);
        if area <= 0.0 {
            return; // The eye is behind the face.
        }
        let from = eye.rotation.inverse_transform_point(&from).coords;
        let to = eye.rotation.inverse_transform_point(&to).coords;
        let along = to - from;
        for index in self.fan.between(&from, &to) {
            let direction = &self.rays()[index].direction;
            let distance = area / direction.xy().perp(&along);
            if self.is_visible(index, distance, face.height, hits) {
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
        // Squared length of a tangent from the eye. It is positive: the robot never touches a
        // cylinder, so the eye is outside.
        let tangent = centre.norm_squared() - CYLINDER_RADIUS * CYLINDER_RADIUS;
        let middle = centre * tangent.sqrt();
        let offset = Vector2::new(-centre.y, centre.x) * CYLINDER_RADIUS;
        for index in self.fan.between(&(middle - offset), &(middle + offset)) {
            let direction = self.rays()[index].direction.xy();
            let square = direction.norm_squared();
            let middle = direction.dot(&centre);
            // Between the tangents, only rounding can make this negative.
            let half_chord = (middle * middle - square * tangent).max(0.0).sqrt();
            let distance = (middle - half_chord) / square;
            if self.is_visible(index, distance, CYLINDER_HEIGHT, hits) {
                let normal = (direction * distance - centre) / CYLINDER_RADIUS;
                let colour = light.shade(self.palette.obstacle, &normal);
                hits[index] = Hit { distance, colour };
            }
        }
    }

    /// Returns whether a ray hits a vertical face at this distance: the ray does not pass over the
    /// face, which is `height` metres tall, and has no nearer hit.
    fn is_visible(&self, index: usize, distance: f64, height: f64, hits: &[Hit; PIXELS]) -> bool {
        let rise = distance * self.rays()[index].direction.z;
        distance > 0.0 && distance < hits[index].distance && self.height + rise <= height
    }

    /// Returns the colour of the solid that contains a point, if any.
    ///
    /// The exit takes precedence over the wall in which it stands. No other solid can contain the
    /// eye, because the robot never touches one.
    fn enclosing_colour(&self, point: &Point2<f64>, world: &World) -> Option<Colour> {
        let from_exit = world.exit().pose().inverse_transform_point(point);
        if from_exit.x.abs() <= EXIT_DEPTH / 2.0 && from_exit.y.abs() <= EXIT_WIDTH / 2.0 {
            Some(self.palette.exit)
        } else if point.x.abs() >= ROOM_SIDE / 2.0 || point.y.abs() >= ROOM_SIDE / 2.0 {
            Some(self.palette.wall)
        } else {
            None
        }
    }
}

/// A vertical face. Seen from `from` towards `to`, its visible side is on the left and the solid on
/// the right.
#[derive(Debug, Clone, Copy)]
struct Face {
    from: Point2<f64>,
    to: Point2<f64>,
    height: f64,
    colour: [u8; CHANNELS],
}

/// Returns the faces of a vertical prism. The outline is clockwise around a solid and
/// counter-clockwise around a cavity.
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

/// Returns the corners of the exit in the ground plan, clockwise.
fn exit_outline(exit: &Exit) -> [Point2<f64>; 4] {
    const X: f64 = EXIT_DEPTH / 2.0;
    const Y: f64 = EXIT_WIDTH / 2.0;
    [(X, Y), (X, -Y), (-X, -Y), (-X, Y)].map(|(x, y)| exit.pose() * Point2::new(x, y))
}
