use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `diagnostic_msgs/msg/KeyValue`: a number, or whatever else, with its name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    /// What it is, with its unit.
    pub key: String,
    /// How much it is.
    pub value: String,
}

impl Message for KeyValue {}

impl RosMessage for KeyValue {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "KeyValue";
}
