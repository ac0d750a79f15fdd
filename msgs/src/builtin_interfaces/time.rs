use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::RosMessage;

/// `builtin_interfaces/msg/Time`: a moment, counted from the zero of its clock.
///
/// It keeps the two numbers of the wire. ros2-client's `Time` is one count of nanoseconds, which
/// would not give every stamp back as it came. The derived order is that of time as long as
/// `nanosec` is below one second.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub struct Time {
    /// Whole seconds; negative before the zero of the clock.
    pub sec: i32,
    /// Nanoseconds after `sec`, 0 to 999,999,999.
    pub nanosec: u32,
}

impl Message for Time {}

impl RosMessage for Time {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Time";
}
