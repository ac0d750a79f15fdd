use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::IndividualTypeDescription;
use crate::RosMessage;

/// `type_description_interfaces/msg/TypeDescription`: a type with all that it stands on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TypeDescription {
    /// The type.
    pub type_description: IndividualTypeDescription,
    /// The types of its fields, of their fields, and so on: each once, by name.
    pub referenced_type_descriptions: Vec<IndividualTypeDescription>,
}

impl Message for TypeDescription {}

impl RosMessage for TypeDescription {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "TypeDescription";
}
