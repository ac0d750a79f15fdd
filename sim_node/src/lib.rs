//! The simulator of Evac: a room with an exit, obstacles, and a robot with a camera.
//!
//! - [`world`]: the room, the obstacles, the robot, and the rules of an episode.
//! - [`camera`]: renders the image of the robot's camera from a [`world::World`].
//! - [`reality`]: perturbations of camera, light, motion and odometry.
//! - [`Simulation`]: a world, its camera and its odometry.
//! - [`ros`]: the ROS 2 node.
//!
//! Only `ros` depends on ROS. The same seed and actions give the same numbers and
//! bytes on every machine: trigonometric functions come from libm, through nalgebra, because the
//! last bits of the results from `std` depend on the platform.
//!
//! Units and axes follow REP-103: metres, radians, x forward, y left, z up, angles
//! counter-clockwise.

pub mod camera;
pub mod reality;
pub mod ros;
mod simulation;
pub mod world;

pub use simulation::Simulation;
