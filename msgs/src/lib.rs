//! The messages and services of Evac.
//!
//! This directory is both the ROS 2 interface package `evac_msgs` and this crate. The build script
//! generates the Rust types from the files in `msg/` and `srv/`; comments in these files become the
//! documentation of the types.
//!
//! Each struct has exactly the fields of the definition, in the same order: CDR transmits no field
//! names, so the order of the fields determines the wire format.
//!
//! # Examples
//!
//! ```
//! use evac_msgs::{ActionCommand, status, step};
//!
//! let request = step::Request { action: ActionCommand::FORWARD, ..Default::default() };
//! assert_eq!(request.action, 3);
//! assert_eq!(status::name(status::EPISODE_OVER), "EPISODE_OVER");
//! ```

pub mod status;

include!(concat!(env!("OUT_DIR"), "/interfaces.rs"));
