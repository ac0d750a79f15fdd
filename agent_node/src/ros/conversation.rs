//! The client side of the services `reset` and `step`, without DDS: takes responses and returns
//! requests.
//!
//! Each request carries numbers by which the simulator recognizes a retry, so a client can retry
//! any request until it gets a response. A restarted simulator has lost the episode. An episode is
//! fully determined by its seed and actions, so the client repeats the reset and replays the
//! actions to restore the simulator's state.

use std::{
    hash::{DefaultHasher, Hash, Hasher},
    num::{NonZeroU32, NonZeroU64},
};

use evac_msgs::{reset, status, step};
use log::warn;
use ros_interfaces::{sensor_msgs::Image as ImageMessage, std_msgs::Header};
use task::{Action, Image, Step};

use super::simulator_error::SimulatorError;

/// What to do after receiving the response to a step request.
#[derive(Clone, Debug, PartialEq)]
pub enum AfterStep {
    /// Return this result: the step is complete.
    Done(Step),
    /// Send this request: the episode is being replayed.
    Step(step::Request),
    /// Send this request: the simulator was restarted, and the replay starts with a reset. Pass the
    /// response to [`Conversation::repeated`].
    Reset(reset::Request),
}

/// The state of a client of one simulator: its request numbers and its current episode.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Conversation {
    /// The number of the latest reset request.
    request: u64,
    episode: Option<Episode>,
}

/// The current episode, with everything that a replay needs.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Episode {
    seed: NonZeroU64,
    scenario: String,
    /// The simulator's number for the episode, from the response to the latest reset.
    number: u64,
    /// The actions of the completed steps.
    actions: Vec<Action>,
    /// The action of the step in progress.
    pending: Option<Action>,
    /// How many actions of the episode the simulator has executed since the latest reset.
    executed: usize,
    /// The digest of the latest image; `None` before the first image of the episode.
    digest: Option<u64>,
    /// The header of the latest image, which is also the header of messages about this image.
    header: Header,
}

impl Conversation {
    /// Creates the state of a client without an episode.
    ///
    /// `numbering` is the upper half of the client's reset request numbers. It must be unique among
    /// the clients of a simulator, because the simulator uses it to identify the client.
    pub fn new(numbering: NonZeroU32) -> Conversation {
        Conversation { request: u64::from(numbering.get()) << 32, episode: None }
    }

    /// Returns the header of the latest image; `None` before the first reset.
    pub fn header(&self) -> Option<&Header> {
        self.episode.as_ref().map(|episode| &episode.header)
    }

    /// Begins an episode and returns the request to send. Pass the response to
    /// [`begun`](Self::begun).
    pub fn begin_episode(&mut self, seed: NonZeroU64, scenario: &str) -> reset::Request {
        let episode = self.episode.insert(Episode {
            seed,
            scenario: scenario.to_owned(),
            number: 0,
            actions: Vec::new(),
            pending: None,
            executed: 0,
            digest: None,
            header: Header::default(),
        });
        episode.reset(&mut self.request)
    }

    /// Returns the first image of the episode, given the response to the request from
    /// [`begin_episode`](Self::begin_episode).
    ///
    /// # Errors
    ///
    /// Returns an error if the simulator refused the reset or sent an invalid image, or if no
    /// episode has begun.
    pub fn begun(&mut self, response: reset::Response) -> Result<Image, SimulatorError> {
        let episode = self.episode.as_mut().ok_or(SimulatorError::NoEpisode)?;
        episode.begin(response)
    }

    /// Begins a step and returns the request to send. Pass the response to
    /// [`stepped`](Self::stepped).
    ///
    /// # Errors
    ///
    /// Returns [`SimulatorError::NoEpisode`] if there is no episode, or if the response to its
    /// reset has not arrived yet.
    pub fn begin_step(&mut self, action: Action) -> Result<step::Request, SimulatorError> {
        // Without a digest, the response to the reset is still pending.
        let episode = self.episode.as_mut().filter(|episode| episode.digest.is_some());
        let episode = episode.ok_or(SimulatorError::NoEpisode)?;
        episode.pending = Some(action);
        Ok(episode.step(action))
    }

    /// Processes the response to the latest step request and returns the result of the step or the
    /// next request of a replay.
    ///
    /// # Errors
    ///
    /// Returns an error if the simulator refused the step, sent an invalid image, or sent an image
    /// that differs from the one before its restart.
    pub fn stepped(&mut self, response: step::Response) -> Result<AfterStep, SimulatorError> {
        let episode = self.episode.as_mut().ok_or(SimulatorError::NoEpisode)?;
        if response.status == status::SIMULATOR_RESTARTED {
            let steps = episode.actions.len();
            warn!("the simulator was restarted: replaying {steps} steps of the episode");
            return Ok(AfterStep::Reset(episode.reset(&mut self.request)));
        }
        check(response.status, response.message)?;
        let image = image_of(response.image, &mut episode.header)?;
        episode.executed += 1;
        if episode.executed <= episode.actions.len() {
            return Ok(AfterStep::Step(episode.replay(&image)?));
        }
        episode.actions.extend(episode.pending.take());
        episode.digest = Some(digest(&image));
        Ok(AfterStep::Done(Step {
            image,
            reward: response.reward,
            terminated: response.terminated,
            truncated: response.truncated,
            blocked: response.blocked,
        }))
    }

    /// Returns the first step request of a replay, given the response to the request from
    /// [`AfterStep::Reset`].
    ///
    /// # Errors
    ///
    /// Returns an error if the simulator refused the reset, sent an invalid image, or sent an image
    /// that differs from the one before its restart.
    pub fn repeated(&mut self, response: reset::Response) -> Result<step::Request, SimulatorError> {
        let episode = self.episode.as_mut().ok_or(SimulatorError::NoEpisode)?;
        // `begin` overwrites the digest of the latest image, which the replay must reproduce.
        let expected = episode.digest;
        let image = episode.begin(response)?;
        episode.digest = expected;
        episode.replay(&image)
    }
}

impl Episode {
    /// Returns the request that resets the simulator to the start of the episode, with the next
    /// request number.
    fn reset(&self, request: &mut u64) -> reset::Request {
        *request += 1;
        reset::Request { request: *request, seed: self.seed.get(), scenario: self.scenario.clone() }
    }

    /// Returns the request for the next step, with this action.
    fn step(&self, action: Action) -> step::Request {
        let step = self.executed as u32 + 1;
        step::Request { episode: self.number, step, action: action.index() }
    }

    /// Returns the first image of the episode from the response to a reset.
    fn begin(&mut self, response: reset::Response) -> Result<Image, SimulatorError> {
        check(response.status, response.message)?;
        let image = image_of(response.image, &mut self.header)?;
        self.number = response.episode;
        self.executed = 0;
        self.digest = Some(digest(&image));
        Ok(image)
    }

    /// Returns the next step request of a replay whose latest image is `image`: a repetition of the
    /// next completed step or, after the last completed step, the request for the step in progress.
    fn replay(&self, image: &Image) -> Result<step::Request, SimulatorError> {
        if let Some(action) = self.actions.get(self.executed) {
            return Ok(self.step(*action));
        }
        if self.digest != Some(digest(image)) {
            return Err(SimulatorError::NotReproducible { step: self.executed, seed: self.seed });
        }
        let action = self.pending.ok_or(SimulatorError::NoEpisode)?;
        Ok(self.step(action))
    }
}

/// Returns an error unless the status of a response is `OK`.
fn check(code: u8, message: String) -> Result<(), SimulatorError> {
    match code {
        status::OK => Ok(()),
        status::SUPERSEDED => Err(SimulatorError::TakenOver(message)),
        other => Err(SimulatorError::Refused(format!("{}: {message}", status::name(other)))),
    }
}

/// Returns the image of a message and stores the header of the message in `header`.
fn image_of(message: ImageMessage, header: &mut Header) -> Result<Image, SimulatorError> {
    let (image, latest) = image(message)?;
    *header = latest;
    Ok(image)
}

/// Returns a hash of an image, which takes less memory than the image. (A resumed training run
/// compares the bytes themselves.)
fn digest(image: &Image) -> u64 {
    let mut hasher = DefaultHasher::new();
    image.hash(&mut hasher);
    hasher.finish()
}

/// Returns the 20 x 7 image that the networks take as input, and the header of the message.
///
/// # Errors
///
/// Returns [`SimulatorError::BadImage`] if the size, encoding or row length of the message is not
/// as expected.
pub fn image(message: ImageMessage) -> Result<(Image, Header), SimulatorError> {
    let (width, height, encoding) = (message.width, message.height, message.encoding.as_str());
    if (width, height, encoding, message.step) != (20, 7, "rgb8", 60) {
        return Err(SimulatorError::BadImage(format!(
            "image: invalid format {width} x {height}, encoding '{encoding}', {} bytes per row \
             (expected: 20 x 7, encoding 'rgb8', 60 bytes per row)",
            message.step
        )));
    }
    match Image::try_from(message.data) {
        Ok(image) => Ok((image, message.header)),
        Err(error) => Err(SimulatorError::BadImage(error.to_string())),
    }
}
