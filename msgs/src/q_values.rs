use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Header, RosMessage};

/// `evac_msgs/msg/QValues`: what the agent expects of each action, and which it chose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QValues {
    /// The header of the image that the values were computed from.
    pub header: Header,
    /// The expected discounted return of each action, in the order of the constants of
    /// [`ActionCommand`](crate::ActionCommand).
    pub values: [f32; 7],
    /// The chosen action.
    pub action: u8,
    /// The action was drawn at random (epsilon-greedy exploration), not for its value.
    pub explored: bool,
}

impl Message for QValues {}

impl RosMessage for QValues {
    const PACKAGE: &str = crate::PACKAGE;
    const NAME: &str = "QValues";
}
