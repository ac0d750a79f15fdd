use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Header, RosMessage};

/// `evac_msgs/msg/ActionCommand`: the robot's next move, a turn on the spot and then 0.1524 m (half
/// a foot) forward.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActionCommand {
    /// The stamp of the image that this action answers; the frame is empty.
    pub header: Header,
    /// Which of the seven turns: one of the constants of this type.
    pub action: u8,
    /// The simulator has this action from its service `step` already and must not execute it
    /// again; the message is for whoever watches.
    pub sent_by_service: bool,
}

impl ActionCommand {
    /// Turn 135 degrees to the right (clockwise), then go forward.
    pub const TURN_RIGHT_135: u8 = 0;
    /// Turn 90 degrees to the right, then go forward.
    pub const TURN_RIGHT_90: u8 = 1;
    /// Turn 45 degrees to the right, then go forward.
    pub const TURN_RIGHT_45: u8 = 2;
    /// Go forward without a turn.
    pub const FORWARD: u8 = 3;
    /// Turn 45 degrees to the left (counter-clockwise), then go forward.
    pub const TURN_LEFT_45: u8 = 4;
    /// Turn 90 degrees to the left, then go forward.
    pub const TURN_LEFT_90: u8 = 5;
    /// Turn 135 degrees to the left, then go forward.
    pub const TURN_LEFT_135: u8 = 6;
}

impl Message for ActionCommand {}

impl RosMessage for ActionCommand {
    const PACKAGE: &str = crate::PACKAGE;
    const NAME: &str = "ActionCommand";
}
