use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `type_description_interfaces/msg/TypeSource`: what a type was defined by.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TypeSource {
    /// The full name of the type, such as `std_msgs/msg/Header`.
    pub type_name: String,
    /// How the definition is written: [`TypeSource::MSG`], [`TypeSource::SRV`] or
    /// [`TypeSource::IMPLICIT`].
    pub encoding: String,
    /// The definition; empty if it is implicit.
    pub raw_file_contents: String,
}

impl TypeSource {
    /// A `.msg` file.
    pub const MSG: &str = "msg";
    /// A `.srv` file.
    pub const SRV: &str = "srv";
    /// No file of its own: the request, the response or the event of a service.
    pub const IMPLICIT: &str = "implicit";
}

impl Message for TypeSource {}

impl RosMessage for TypeSource {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "TypeSource";
}
