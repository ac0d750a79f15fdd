use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `visualization_msgs/msg/MeshFile`: the mesh of a marker, sent along with it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Its name, whose ending says the format.
    pub filename: String,
    /// The file.
    pub data: Vec<u8>,
}

impl Message for MeshFile {}

impl RosMessage for MeshFile {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "MeshFile";
}
