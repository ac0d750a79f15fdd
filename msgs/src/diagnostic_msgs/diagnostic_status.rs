use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::KeyValue;
use crate::RosMessage;

/// `diagnostic_msgs/msg/DiagnosticStatus`: how a part of a robot is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// How well: one of the levels below.
    pub level: u8,
    /// The part, in the form "node: part".
    pub name: String,
    /// How it is, in a few words.
    pub message: String,
    /// Which piece of hardware it is; empty for software.
    pub hardware_id: String,
    /// The same in numbers.
    pub values: Vec<KeyValue>,
}

impl DiagnosticStatus {
    /// A level: all is well.
    pub const OK: u8 = 0;
    /// A level: somebody should look.
    pub const WARN: u8 = 1;
    /// A level: it does not work.
    pub const ERROR: u8 = 2;
    /// A level: nothing was heard of it for a while.
    pub const STALE: u8 = 3;
}

impl Message for DiagnosticStatus {}

impl RosMessage for DiagnosticStatus {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "DiagnosticStatus";
}
