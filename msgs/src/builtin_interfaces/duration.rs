use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `builtin_interfaces/msg/Duration`: a span of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duration {
    /// Whole seconds.
    pub sec: i32,
    /// Nanoseconds after `sec`, 0 to 999,999,999.
    pub nanosec: u32,
}

impl Message for Duration {}

impl RosMessage for Duration {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Duration";
}
