//! The node: the room over DDS, what the node publishes, and its commands.

pub mod commands;
mod console;
mod escapes;
mod ground_truth;
mod parameters;
mod publishers;
mod simulator;

pub use simulator::Simulator;
