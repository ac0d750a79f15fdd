use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Header, RosMessage};

/// `evac_msgs/msg/EpisodeStatus`: where an episode stands after a reset or a step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EpisodeStatus {
    /// The stamp of the image of this reset or step; the frame is empty.
    pub header: Header,
    /// The number of the episode: the upper 32 bits are random per start of the simulator, the
    /// lower 32 count its resets from 1.
    pub episode: u64,
    /// The name of the scenario, such as `three_cylinders`.
    pub scenario: String,
    /// The seed of the reset; 0 if the simulator's own random state went on.
    pub seed: u64,
    /// Steps since the reset; 0 for the reset itself.
    pub step: u32,
    /// The action of this step (a constant of [`ActionCommand`](crate::ActionCommand)), or
    /// [`EpisodeStatus::NONE`] after a reset.
    pub action: u8,
    /// The reward of this step; 0 after a reset.
    pub reward: f32,
    /// The robot has reached the exit; the episode is over.
    pub terminated: bool,
    /// The limit of steps has been reached; the episode is over.
    pub truncated: bool,
    /// A wall or an obstacle was in the way, so the robot stayed where it was.
    pub blocked: bool,
}

impl EpisodeStatus {
    /// The value of `action` after a reset.
    pub const NONE: u8 = 255;
}

impl Message for EpisodeStatus {}

impl RosMessage for EpisodeStatus {
    const PACKAGE: &str = crate::PACKAGE;
    const NAME: &str = "EpisodeStatus";
}
