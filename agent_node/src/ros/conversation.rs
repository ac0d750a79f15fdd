//! What is said to a simulator, and what its answers mean. No DDS here: answers in, requests out.
//!
//! Every request has numbers by which the simulator knows it again, so it may be asked as often as
//! it takes. A restarted simulator knows nothing of the episode, but with a seeded reset a room is a
//! function of the seed and the actions so far: repeating both brings it back to the very same state.

use std::num::{NonZeroU32, NonZeroU64};

use evac_msgs::{Header, reset, status, step};
use log::warn;
use task::{Action, Image};

use crate::environment::{EnvironmentError, Step};

/// What is asked of a simulator.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Request {
    /// By `/reset`.
    Reset(reset::Request),
    /// By `/step`.
    Step(step::Request),
}

/// What it answers.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// To a reset.
    Reset(reset::Response),
    /// To a step.
    Step(step::Response),
}

/// What follows from an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Next {
    /// There is more to ask.
    Ask(Request),
    /// What was begun is done.
    Done(Done),
}

/// What was begun, and has come to its end.
#[derive(Clone, Debug, PartialEq)]
pub enum Done {
    /// An episode has begun, and the robot sees this.
    Reset(Image),
    /// A step has been taken.
    Step(Step),
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
    /// What was seen last; none before the episode's first image.
    image: Option<Image>,
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

    /// Begins an episode: what is to be asked first.
    pub fn begin_episode(&mut self, seed: NonZeroU64, scenario: &str) -> Request {
        let episode = self.episode.insert(Episode {
            seed,
            scenario: scenario.to_owned(),
            number: 0,
            actions: Vec::new(),
            begun: None,
            taken: 0,
            image: None,
            header: Header::default(),
        });
        episode.reset(&mut self.request)
    }

    /// Begins a step: what is to be asked first.
    pub fn begin_step(&mut self, action: Action) -> Result<Request, EnvironmentError> {
        // An episode that has shown nothing has not been begun by a simulator yet.
        let episode = self.episode.as_mut().filter(|episode| episode.image.is_some());
        let episode = episode.ok_or(EnvironmentError::NotBegun("episode"))?;
        episode.begun = Some(action);
        Ok(episode.step(action))
    }

    /// Takes in the answer to the latest request.
    pub fn hear(&mut self, answer: Answer) -> Result<Next, EnvironmentError> {
        let episode = self.episode.as_mut().ok_or(EnvironmentError::NotBegun("episode"))?;
        match answer {
            Answer::Reset(response) => {
                check(response.status, response.message)?;
                let shown = image(&response.image)?;
                episode.number = response.episode;
                episode.taken = 0;
                episode.header = response.image.header;
                episode.go_on(shown)
            }
            Answer::Step(response) if response.status == status::SIMULATOR_RESTARTED => {
                let steps = episode.actions.len();
                warn!("the simulator was restarted: repeating {steps} steps");
                Ok(Next::Ask(episode.reset(&mut self.request)))
            }
            Answer::Step(response) => {
                check(response.status, response.message)?;
                let shown = image(&response.image)?;
                episode.header = response.image.header;
                episode.taken += 1;
                if episode.taken <= episode.actions.len() {
                    return episode.go_on(shown);
                }
                episode.actions.extend(episode.begun.take());
                episode.image = Some(shown.clone());
                Ok(Next::Done(Done::Step(Step {
                    image: shown,
                    reward: response.reward,
                    terminated: response.terminated,
                    truncated: response.truncated,
                    blocked: response.blocked,
                })))
            }
        }
    }
}

impl Episode {
    /// The reset that begins the episode, or begins it anew, under the next number.
    fn reset(&self, request: &mut u64) -> Request {
        *request += 1;
        Request::Reset(reset::Request {
            request: *request,
            seed: self.seed.get(),
            scenario: self.scenario.clone(),
        })
    }

    /// The next step, with this action.
    fn step(&self, action: Action) -> Request {
        Request::Step(step::Request {
            episode: self.number,
            step: self.taken as u32 + 1,
            action: action.index(),
        })
    }

    /// What follows when the room shows an image that it must have shown before, if the episode is
    /// being repeated.
    fn go_on(&mut self, shown: Image) -> Result<Next, EnvironmentError> {
        if let Some(action) = self.actions.get(self.taken) {
            return Ok(Next::Ask(self.step(*action)));
        }
        let expected = self.image.get_or_insert_with(|| shown.clone());
        if *expected != shown {
            let step = self.taken as u32;
            return Err(EnvironmentError::NotRepeatable { step, seed: self.seed.get() });
        }
        Ok(match self.begun {
            Some(action) => Next::Ask(self.step(action)),
            None => Next::Done(Done::Reset(shown)),
        })
    }
}

/// Whether an answer says that what was asked is done, or why it is not.
fn check(code: u8, message: String) -> Result<(), EnvironmentError> {
    match code {
        status::OK => Ok(()),
        status::SUPERSEDED => Err(EnvironmentError::TakenOver(message)),
        other => Err(EnvironmentError::Refused(format!("{}: {message}", status::name(other)))),
    }
}

/// The image of a message, if it is one of the camera that the networks know.
pub fn image(message: &evac_msgs::Image) -> Result<Image, EnvironmentError> {
    let (width, height, encoding) = (message.width, message.height, message.encoding.as_str());
    if (width, height, encoding, message.step) != (20, 7, "rgb8", 60) {
        return Err(EnvironmentError::BadImage(format!(
            "an image of {width} x {height} pixels, encoding '{encoding}', {} bytes a row: expected \
             20 x 7, rgb8, 60",
            message.step
        )));
    }
    Image::try_from(message.data.as_slice())
        .map_err(|error| EnvironmentError::BadImage(error.to_string()))
}
