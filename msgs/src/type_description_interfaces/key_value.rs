use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `type_description_interfaces/msg/KeyValue`: something else, under a name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    /// What it is.
    pub key: String,
    /// What there is to say.
    pub value: String,
}

impl Message for KeyValue {}

impl RosMessage for KeyValue {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "KeyValue";
}
