use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::Field;
use crate::RosMessage;

/// `type_description_interfaces/msg/IndividualTypeDescription`: a type without the types of its fields.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct IndividualTypeDescription {
    /// Its full name, such as `std_msgs/msg/Header`.
    pub type_name: String,
    /// Its fields, in their order.
    pub fields: Vec<Field>,
}

impl Message for IndividualTypeDescription {}

impl RosMessage for IndividualTypeDescription {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "IndividualTypeDescription";
}
