use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Header, RosMessage};

/// `evac_msgs/msg/TrainingStatus`: how a training goes, published at the end of each episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrainingStatus {
    /// The end of the episode by the agent's clock; the frame is empty.
    pub header: Header,
    /// The episode that has ended, counted from 0 as in the paper's equation 4.
    pub episode: u32,
    /// How many episodes the training has.
    pub episodes: u32,
    /// Steps of this episode.
    pub steps: u32,
    /// Steps of all episodes so far.
    pub total_steps: u64,
    /// The sum of this episode's rewards, not discounted.
    pub episode_return: f32,
    /// The probability of a random action in this episode.
    pub epsilon: f32,
    /// The mean loss (the paper's equation 5) of this episode's updates; NaN if there was none.
    pub loss: f32,
    /// Steps per second of wall-clock time, since the start of the training.
    pub steps_per_s: f32,
    /// The share of the latest 50 episodes that ended at the exit, 0 to 1.
    pub success_rate: f32,
}

impl Message for TrainingStatus {}

impl RosMessage for TrainingStatus {
    const PACKAGE: &str = crate::PACKAGE;
    const NAME: &str = "TrainingStatus";
}
