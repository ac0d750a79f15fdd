//! The simulator of Evac: a room with an exit, a robot that wants to leave it, and the camera that
//! the robot sees through.
//!
//! - [`world`]: the room, its obstacles, the robot, and the rules of an episode;
//! - [`camera`]: what the robot's camera sees of a [`world::World`].
//!
//! Both are plain computation that knows no ROS: a seed and a list of actions give the same
//! numbers and the same bytes on every machine. For that, trigonometry comes from libm (through
//! nalgebra or directly), never from `std`, whose last bits depend on the platform.
//!
//! Lengths are metres and angles radians, as REP-103 has them: x forward, y left, z up, angles
//! counter-clockwise.

pub mod camera;
pub mod ros;
pub mod world;
