//! `evac_msgs/srv/Reset`: begin a new episode.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::{Image, RosService};

/// The service that begins a new episode.
#[derive(Clone, Copy, Debug)]
pub struct Reset;

impl RosService for Reset {
    const PACKAGE: &str = crate::PACKAGE;
    const NAME: &str = "Reset";
    type Request = Request;
    type Response = Response;
}

/// What a client asks of [`Reset`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Request {
    /// The client's own number for this reset; 0: none. Repeating the latest number returns the
    /// stored answer and resets nothing, so a lost reply can be asked for again; an older one is
    /// refused. A program draws the upper 32 bits at random: they are its name, whichever of its
    /// clients asks.
    pub request: u64,
    /// Everything random in the episode, moving obstacles included, follows from this seed.
    /// 0: go on with the simulator's own random state.
    pub seed: u64,
    /// The name of the scenario, such as `three_cylinders`; empty: keep the current one.
    pub scenario: String,
}

impl Message for Request {}

/// What the simulator answers to [`Reset`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Response {
    /// A new episode has begun (or had, if this repeats a request).
    pub success: bool,
    /// Why not: one of the constants of [`status`](crate::status).
    pub status: u8,
    /// What was wrong and why, for people; empty on success.
    pub message: String,
    /// The number of the new episode: the upper 32 bits are random per start of the simulator, the
    /// lower 32 count its resets from 1.
    pub episode: u64,
    /// The first image of the episode; empty if there is no new episode.
    pub image: Image,
}

impl Message for Response {}
