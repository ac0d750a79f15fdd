//! The ROS 2 interfaces of Evac: the Rust type of every message that crosses the wire.
//!
//! This directory is two things at once. ROS 2 builds it as the interface package `evac_msgs` from
//! `msg/` and `srv/`; Cargo builds it as this crate from `src/`. The definitions are written twice,
//! and `tests/interfaces.rs` fails when the two differ in a field's name, type or order, or in the
//! value of a constant. They are in this crate as text, too: a node tells others what its types look
//! like, and by which hash they are told apart ([`type_description_interfaces::TypeDescription`]).
//!
//! | module | what it holds |
//! |---|---|
//! | the crate root | every topic message, and the markers [`Reset`] and [`Step`] of the services |
//! | [`reset`], [`step`] | the request and the response of each service |
//! | [`status`] | the values of the field `status` of both responses |
//! | [`builtin_interfaces`], [`std_msgs`], [`diagnostic_msgs`], [`geometry_msgs`], [`sensor_msgs`], [`nav_msgs`], [`rosgraph_msgs`], [`tf2_msgs`], [`type_description_interfaces`], [`visualization_msgs`] | the standard ROS types that Evac needs |
//! | [`definition`] | the text of every definition, and how to read it |
//!
//! A type here is nothing but its fields in the order of the ROS definition: rustdds encodes them as
//! CDR by way of serde, which has no names on the wire, so the order is the format. What the values
//! mean (what an action does, when a step is refused) belongs to the nodes.

mod action_command;
mod description;
mod episode_status;
mod interface;
mod q_values;
mod training_status;

pub mod builtin_interfaces;
pub mod definition;
pub mod diagnostic_msgs;
pub mod geometry_msgs;
pub mod nav_msgs;
pub mod reset;
pub mod rosgraph_msgs;
pub mod sensor_msgs;
pub mod status;
pub mod std_msgs;
pub mod step;
pub mod tf2_msgs;
pub mod type_description_interfaces;
pub mod visualization_msgs;

pub use action_command::ActionCommand;
pub use builtin_interfaces::Time;
pub use episode_status::EpisodeStatus;
pub use interface::{RosMessage, RosService};
pub use q_values::QValues;
pub use reset::Reset;
pub use sensor_msgs::Image;
pub use std_msgs::Header;
pub use step::Step;
pub use training_status::TrainingStatus;

/// The ROS package of the interfaces that this crate defines.
const PACKAGE: &str = "evac_msgs";
