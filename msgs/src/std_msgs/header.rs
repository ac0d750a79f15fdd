use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{RosMessage, Time};

/// `std_msgs/msg/Header`: when and in which frame the data of a message hold.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Header {
    /// When, on the simulator's clock.
    pub stamp: Time,
    /// The frame of tf that positions and directions are given in; empty where there are none.
    pub frame_id: String,
}

impl Message for Header {}

impl RosMessage for Header {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Header";
}
