//! The belief of a robot: the rooms that are consistent with all images that it has observed.

use nalgebra::{Isometry2, Point2, distance};
use sim_node::{
    camera::{Camera, Frame},
    world::{Layout, World},
};
use task::Random;

/// Number of rooms to draw before the belief is taken as it is.
const ATTEMPTS: u32 = 20_000;
/// Minimum distance between the centres of two static cylinders, in metres.
const APART: f64 = 0.7;

/// Poses, and the image that the robot has seen at each.
pub type Seen = Vec<(Isometry2<f64>, Frame)>;

/// Draws rooms that agree with everything that the robot has seen in a room.
pub struct Belief<'a> {
    camera: &'a Camera,
    truth: &'a World,
    /// Draws rooms from the distribution of the scenario, given the start pose.
    prior: World,
    random: Random,
    pub seen: Seen,
}

impl<'a> Belief<'a> {
    /// Starts at the current pose of the robot. `seed` determines the rooms that are drawn.
    pub fn new(camera: &'a Camera, truth: &'a World, seed: u64) -> Belief<'a> {
        let mut prior = truth.clone();
        prior.set_layout(Layout { robot: Some(*truth.robot()), ..Layout::default() });
        let random = Random::from_key([seed, 0, 0, 0]);
        let seen = vec![(*truth.robot(), camera.render(truth))];
        Belief { camera, truth, prior, random, seen }
    }

    /// Adds rooms until there are `count`. If everything has been seen, the true room is the only
    /// one.
    pub fn complete(&mut self, rooms: &mut Vec<World>, count: usize) {
        let visible = self.visible_cylinders();
        let exit_is_visible = self.seen.iter().any(|(_, frame)| shows_exit(frame));
        let hidden = self.truth.cylinders().len() - visible.len();
        if exit_is_visible && hidden == 0 {
            rooms.clear();
            rooms.push(self.truth.clone());
            return;
        }
        for _ in 0..ATTEMPTS {
            if rooms.len() >= count {
                return;
            }
            let seed = std::num::NonZeroU64::new(self.random.word() | 1);
            self.prior.reset(seed, None).expect("a room around the robot's start pose is possible");
            let exit = if exit_is_visible { *self.truth.exit() } else { *self.prior.exit() };
            let drawn = self.prior.cylinders().iter().map(|cylinder| cylinder.centre());
            let centres: Vec<Point2<f64>> =
                visible.iter().copied().chain(drawn.take(hidden)).collect();
            let apart = (0..centres.len()).all(|index| {
                centres[..index].iter().all(|other| distance(other, &centres[index]) >= APART)
            });
            if !apart {
                continue;
            }
            let mut room = self.truth.clone();
            room.place_objects(exit, &centres);
            if self.seen.iter().all(|(pose, frame)| self.image(&mut room, pose) == *frame) {
                rooms.push(room);
            }
        }
        if rooms.is_empty() {
            rooms.push(self.truth.clone());
        }
    }

    /// Returns the centres of the cylinders that at least one image shows: without them, it would
    /// be different.
    fn visible_cylinders(&self) -> Vec<Point2<f64>> {
        let centres: Vec<Point2<f64>> =
            self.truth.cylinders().iter().map(|cylinder| cylinder.centre()).collect();
        let is_visible = |index: &usize| {
            let mut others = centres.clone();
            others.remove(*index);
            let mut room = self.truth.clone();
            room.place_objects(*self.truth.exit(), &others);
            self.seen.iter().any(|(pose, frame)| self.image(&mut room, pose) != *frame)
        };
        (0..centres.len()).filter(is_visible).map(|index| centres[index]).collect()
    }

    fn image(&self, room: &mut World, pose: &Isometry2<f64>) -> Frame {
        room.place_robot(*pose);
        self.camera.render(room)
    }
}

/// Returns whether a pixel has the hue of the exit, which no other surface has.
fn shows_exit(frame: &Frame) -> bool {
    let (pixels, _) = frame.bytes().as_chunks();
    pixels.iter().any(|&[red, green, blue]| red == 0 && green > 0 && blue == 0)
}
