use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::FieldType;
use crate::RosMessage;

/// `type_description_interfaces/msg/Field`: a field of a type.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type.
    pub r#type: FieldType,
    /// Its default value, as Python writes it; empty: none.
    pub default_value: String,
}

impl Message for Field {}

impl RosMessage for Field {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Field";
}
