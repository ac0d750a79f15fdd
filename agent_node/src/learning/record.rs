//! What a training leaves behind: one record per episode.

use serde::{Deserialize, Serialize};

/// One row of `episodes.csv`. The column names are part of the command's contract.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRecord {
    /// Counts from 0, as `e` in eq. 4.
    pub episode: u32,
    /// Actions taken, blocked ones included.
    pub steps: u32,
    /// The undiscounted sum of the rewards.
    #[serde(rename = "return")]
    pub episode_return: f32,
    /// The exploration probability of this episode (eq. 4).
    pub epsilon: f64,
    /// Mean loss (eq. 5) of the episode's updates; empty where there was no update yet.
    pub loss: Option<f64>,
    /// How many of the steps were blocked by a wall or an obstacle.
    pub blocked: u32,
    /// Whether the robot reached the exit; if not, the episode was truncated.
    pub terminated: bool,
}
