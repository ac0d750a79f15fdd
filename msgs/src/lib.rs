//! The messages and services of Evac.
//!
//! This directory is two things at once. ROS 2 builds it as the interface package `evac_msgs`, and
//! Cargo as this crate, whose types `build.rs` writes from the same files in `msg/` and `srv/`: their
//! comments are the documentation here.
//!
//! A type is nothing but its fields in the order of the definition: CDR has no names on the wire, so
//! the order is the format.

pub mod status;

include!(concat!(env!("OUT_DIR"), "/interfaces.rs"));
