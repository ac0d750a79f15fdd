use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{RosMessage, Time};

/// `rosgraph_msgs/msg/Clock`: the time, for nodes that do not go by the wall's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// Now.
    pub clock: Time,
}

impl Message for Clock {}

impl RosMessage for Clock {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Clock";
}
