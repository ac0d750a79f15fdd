//! What is said to a simulator, and what its answers mean. No DDS here: answers in, requests out.
//!
//! Every request has numbers by which the simulator knows it again, so it may be asked as often as
//! it takes. A restarted simulator knows nothing of the episode, but with a seeded reset a room is a
//! function of the seed and the actions so far: repeating both brings it back to the very same state.

use std::{
    hash::{DefaultHasher, Hash, Hasher},
    num::{NonZeroU32, NonZeroU64},
};

use evac_msgs::{reset, status, step};
use log::warn;
use ros_interfaces::{sensor_msgs::Image as ImageMessage, std_msgs::Header};
use task::{Action, Image, Step};

use super::simulator_error::SimulatorError;

/// What follows from the answer to a step.
#[derive(Clone, Debug, PartialEq)]
pub enum AfterStep {
    /// The step that was begun is done.
    Done(Step),
    /// There is another step to ask for.
    Step(step::Request),
    /// The simulator was restarted: the episode has to be begun once more.
    Reset(reset::Request),
}

/// An agent's side of its episodes with one simulator.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Conversation {
    /// The number of the latest reset request.
    request: u64,
    episode: Option<Episode>,
}

/// The episode under way: everything that is needed to repeat it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Episode {
    seed: NonZeroU64,
    scenario: String,
    /// As the simulator numbers it, in the answer to the latest reset.
    number: u64,
    /// The actions whose ends were seen, and the one under way.
    actions: Vec<Action>,
    begun: Option<Action>,
    /// How many of these actions have been taken since the latest reset.
    taken: usize,
    /// The digest of what was seen last; none before the episode's first image.
    seen: Option<u64>,
    /// Of the latest image; what the agent publishes about it carries the same.
    header: Header,
}

impl Conversation {
    /// A conversation whose resets have numbers with this upper half, which must be nobody else's:
    /// by it the simulator knows the agent.
    pub fn new(numbering: NonZeroU32) -> Conversation {
        Conversation { request: u64::from(numbering.get()) << 32, episode: None }
    }

    /// The header of the image that was seen last.
    pub fn header(&self) -> Option<&Header> {
        self.episode.as_ref().map(|episode| &episode.header)
    }

    /// Begins an episode: what to ask. The answer goes to [`begun`](Self::begun).
    pub fn begin_episode(&mut self, seed: NonZeroU64, scenario: &str) -> reset::Request {
        let episode = self.episode.insert(Episode {
            seed,
            scenario: scenario.to_owned(),
            number: 0,
            actions: Vec::new(),
            begun: None,
            taken: 0,
            seen: None,
            header: Header::default(),
        });
        episode.reset(&mut self.request)
    }

    /// The first image of the episode, from the answer to [`begin_episode`](Self::begin_episode)'s
    /// request.
    ///
    /// # Errors
    ///
    /// The simulator refuses, or sends no image of the camera.
    pub fn begun(&mut self, answer: reset::Response) -> Result<Image, SimulatorError> {
        let episode = self.episode.as_mut().ok_or(SimulatorError::NoEpisode)?;
        episode.begin(answer)
    }

    /// Begins a step: what to ask. The answer goes to [`stepped`](Self::stepped).
    ///
    /// # Errors
    ///
    /// No episode has begun.
    pub fn begin_step(&mut self, action: Action) -> Result<step::Request, SimulatorError> {
        // An episode that has shown nothing has not been begun by a simulator yet.
        let episode = self.episode.as_mut().filter(|episode| episode.seen.is_some());
        let episode = episode.ok_or(SimulatorError::NoEpisode)?;
        episode.begun = Some(action);
        Ok(episode.step(action))
    }

    /// What follows from the answer to the latest request for a step.
    ///
    /// # Errors
    ///
    /// The simulator refuses, or sends no image of the camera, or another one than before.
    pub fn stepped(&mut self, answer: step::Response) -> Result<AfterStep, SimulatorError> {
        let episode = self.episode.as_mut().ok_or(SimulatorError::NoEpisode)?;
        if answer.status == status::SIMULATOR_RESTARTED {
            let steps = episode.actions.len();
            warn!("the simulator was restarted: repeating {steps} steps");
            return Ok(AfterStep::Reset(episode.reset(&mut self.request)));
        }
        check(answer.status, answer.message)?;
        let shown = image_of(answer.image, &mut episode.header)?;
        episode.taken += 1;
        if episode.taken <= episode.actions.len() {
            return Ok(AfterStep::Step(episode.repeat(&shown)?));
        }
        episode.actions.extend(episode.begun.take());
        episode.seen = Some(digest(&shown));
        Ok(AfterStep::Done(Step {
            image: shown,
            reward: answer.reward,
            terminated: answer.terminated,
            truncated: answer.truncated,
            blocked: answer.blocked,
        }))
    }

    /// The step to ask for after the answer to the reset of [`AfterStep::Reset`].
    ///
    /// # Errors
    ///
    /// The simulator refuses, or sends no image of the camera, or another one than before.
    pub fn repeated(&mut self, answer: reset::Response) -> Result<step::Request, SimulatorError> {
        let episode = self.episode.as_mut().ok_or(SimulatorError::NoEpisode)?;
        let before = episode.seen;
        let shown = episode.begin(answer)?;
        episode.seen = before;
        episode.repeat(&shown)
    }
}

impl Episode {
    /// The reset that begins the episode, or begins it anew, under the next number.
    fn reset(&self, request: &mut u64) -> reset::Request {
        *request += 1;
        reset::Request { request: *request, seed: self.seed.get(), scenario: self.scenario.clone() }
    }

    /// The next step, with this action.
    fn step(&self, action: Action) -> step::Request {
        step::Request { episode: self.number, step: self.taken as u32 + 1, action: action.index() }
    }

    /// What the simulator shows as it begins the episode.
    fn begin(&mut self, answer: reset::Response) -> Result<Image, SimulatorError> {
        check(answer.status, answer.message)?;
        let shown = image_of(answer.image, &mut self.header)?;
        self.number = answer.episode;
        self.taken = 0;
        self.seen = Some(digest(&shown));
        Ok(shown)
    }

    /// The next step of an episode that is being repeated, which shows this image.
    fn repeat(&self, shown: &Image) -> Result<step::Request, SimulatorError> {
        if let Some(action) = self.actions.get(self.taken) {
            return Ok(self.step(*action));
        }
        if self.seen != Some(digest(shown)) {
            return Err(SimulatorError::NotRepeatable { step: self.taken, seed: self.seed });
        }
        let action = self.begun.ok_or(SimulatorError::NoEpisode)?;
        Ok(self.step(action))
    }
}

/// Whether an answer says that what was asked is done, or why it is not.
fn check(code: u8, message: String) -> Result<(), SimulatorError> {
    match code {
        status::OK => Ok(()),
        status::SUPERSEDED => Err(SimulatorError::TakenOver(message)),
        other => Err(SimulatorError::Refused(format!("{}: {message}", status::name(other)))),
    }
}

/// The image of a message, whose header is put aside.
fn image_of(message: ImageMessage, header: &mut Header) -> Result<Image, SimulatorError> {
    let (shown, latest) = image(message)?;
    *header = latest;
    Ok(shown)
}

/// By which an image is known again; a training compares the bytes themselves as it goes on.
fn digest(image: &Image) -> u64 {
    let mut hasher = DefaultHasher::new();
    image.hash(&mut hasher);
    hasher.finish()
}

/// The image of a message, if it is one of the camera that the networks know, and its header.
///
/// # Errors
///
/// It has another size or encoding.
pub fn image(message: ImageMessage) -> Result<(Image, Header), SimulatorError> {
    let (width, height, encoding) = (message.width, message.height, message.encoding.as_str());
    if (width, height, encoding, message.step) != (20, 7, "rgb8", 60) {
        return Err(SimulatorError::BadImage(format!(
            "an image of {width} x {height} pixels, encoding '{encoding}', {} bytes a row: expected \
             20 x 7, rgb8, 60",
            message.step
        )));
    }
    match Image::try_from(message.data) {
        Ok(image) => Ok((image, message.header)),
        Err(error) => Err(SimulatorError::BadImage(error.to_string())),
    }
}
