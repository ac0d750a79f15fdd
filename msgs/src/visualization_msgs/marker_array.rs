use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::Marker;
use crate::RosMessage;

/// `visualization_msgs/msg/MarkerArray`: markers, obeyed in their order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// The markers.
    pub markers: Vec<Marker>,
}

impl Message for MarkerArray {}

impl RosMessage for MarkerArray {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "MarkerArray";
}
