//! `evac_msgs/srv/Step`: move the robot once.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Image, RosService};

/// The service that moves the robot once.
#[derive(Clone, Copy, Debug)]
pub struct Step;

impl RosService for Step {
    const PACKAGE: &str = crate::PACKAGE;
    const NAME: &str = "Step";
    type Request = Request;
    type Response = Response;
}

/// What a client asks of [`Step`].
///
/// Repeating the last episode and step with the same action returns the stored answer and moves
/// nothing, so a lost reply can be asked for again. That holds for explicit numbers; the zeros are
/// for calls by hand.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Request {
    /// The number of the episode; 0: the current one.
    pub episode: u64,
    /// The number of the step in its episode, from 1; 0: the next one.
    pub step: u32,
    /// Which of the seven turns: a constant of [`ActionCommand`](crate::ActionCommand).
    pub action: u8,
}

impl Message for Request {}

/// What the simulator answers to [`Step`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// The step was taken (or had been, if this repeats a request); a blocked move is a step too.
    pub success: bool,
    /// Why not: one of the constants of [`status`](crate::status).
    pub status: u8,
    /// What was wrong and why, for people; empty on success.
    pub message: String,
    /// What the camera sees after the step; empty if the step was refused.
    pub image: Image,
    /// The reward of the step: 0 at the exit, otherwise -0.1.
    pub reward: f32,
    /// The robot has reached the exit; the episode is over.
    pub terminated: bool,
    /// The limit of steps has been reached; the episode is over.
    pub truncated: bool,
    /// A wall or an obstacle was in the way, so the robot stayed where it was.
    pub blocked: bool,
    /// The episode that the step belongs to.
    pub episode: u64,
    /// The number of the step in its episode, from 1.
    pub step: u32,
}

impl Message for Response {}
