use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::DiagnosticStatus;
use crate::{Header, RosMessage};

/// `diagnostic_msgs/msg/DiagnosticArray`: how the parts of a robot are.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// When.
    pub header: Header,
    /// One for each part.
    pub status: Vec<DiagnosticStatus>,
}

impl Message for DiagnosticArray {}

impl RosMessage for DiagnosticArray {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "DiagnosticArray";
}
