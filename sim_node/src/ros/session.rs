//! The protocol of `/reset`, `/step` and `/action`, as a state machine without DDS.
//!
//! Requests can be lost, duplicated, delayed, or sent by another client. Numbers identify them: a
//! client numbers its resets, the simulator numbers its episodes, and the steps of each episode are
//! numbered. A duplicate gets the stored response, and nothing is executed. A request that is
//! neither new nor a duplicate is refused and changes nothing.

mod reset_ledger;
mod timeline;

use std::num::{NonZeroU32, NonZeroU64};

use evac_msgs::{ActionCommand, EpisodeStatus, reset, status, step};
use rand::RngExt;
use ros_interfaces::{builtin_interfaces::Time, sensor_msgs::Image, std_msgs::Header};
use task::{Action, Scenario};

pub use self::reset_ledger::ClientId;
use self::{
    reset_ledger::{ResetLedger, upper_half},
    timeline::Timeline,
};
use super::messages::{self, StampedPose};
use crate::{
    Simulation,
    reality::Reality,
    world::{Layout, World},
};

/// Maximum number of steps for which the memory of the path is allocated in advance, so that these
/// steps do not reallocate it. Equals the default step limit.
const PATH_CAPACITY: u32 = 10_000;

/// A simulation with its clock, and the state of the protocol.
///
/// The methods that handle requests return the response and, if the request was executed, the
/// [`EpisodeStatus`] to publish.
#[derive(Clone)]
pub struct Session {
    simulation: Simulation,
    time: Timeline,
    /// Number of images taken since the image of the latest step or reset.
    frame: u32,
    /// Duration of a move commanded through `/action`, in nanoseconds.
    motion_time: u64,
    motion: Option<Motion>,
    /// Upper 32 bits of the episode numbers of this run. They are never 0, so no episode number is
    /// below 2^32.
    simulator: NonZeroU32,
    /// Lower 32 bits of the number of the current episode.
    episode: u32,
    seed: u64,
    /// Start pose of the episode, and the pose after each step.
    path: Vec<StampedPose>,
    control: Option<Control>,
    resets: ResetLedger,
    /// The latest action and its response without the image, which can be rendered again.
    latest_step: Option<(u8, step::Response)>,
}

/// A move in progress.
#[derive(Clone)]
struct Motion {
    action: Action,
    /// End of the move, in nanoseconds of wall-clock time.
    end: u64,
}

/// The interface that controls the robot in an episode: the first one used.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Control {
    Service,
    Topic,
}

/// The classification of a `/step` request that is not refused.
enum Verdict {
    /// A duplicate of the latest step, with the stored response.
    Duplicate(step::Response),
    /// The next step of the episode.
    Move { action: Action, number: u32 },
}

/// The status and message of a refused request.
type Refusal = (u8, String);

impl Session {
    /// Creates a session and starts its first episode. Returns the status of that episode, which is
    /// the first status to publish.
    ///
    /// `step_duration` is the simulated duration of a step or reset in seconds. The upper 32 bits
    /// of the episode numbers are drawn at random.
    pub fn new(simulation: Simulation, step_duration: f64) -> (Session, EpisodeStatus) {
        Session::numbered(rand::rng().random(), simulation, step_duration)
    }

    /// Creates a session like [`Session::new`], but with `simulator` as the upper 32 bits of the
    /// episode numbers. `simulator` must differ from the values of earlier runs.
    pub fn numbered(
        simulator: NonZeroU32,
        simulation: Simulation,
        step_duration: f64,
    ) -> (Session, EpisodeStatus) {
        let max_steps = simulation.world().max_steps();
        let mut session = Session {
            path: Vec::with_capacity(max_steps.min(PATH_CAPACITY) as usize + 1),
            simulation,
            time: Timeline::new(step_duration),
            frame: 0,
            motion_time: 0,
            motion: None,
            simulator,
            episode: 0,
            seed: 0,
            control: None,
            resets: ResetLedger::default(),
            latest_step: None,
        };
        let first = session.begin_episode(0);
        (session, first)
    }

    /// Returns the scenario of the current episode.
    pub fn scenario(&self) -> Scenario {
        self.world().scenario()
    }

    /// Returns the simulation.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Returns the world.
    pub fn world(&self) -> &World {
        self.simulation.world()
    }

    /// Returns the path of the current episode: the start pose, and the pose after each step.
    pub fn path(&self) -> &[StampedPose] {
        &self.path
    }

    /// Returns the simulated time, which is the stamp of the latest image.
    pub fn now(&self) -> Time {
        messages::stamp(self.time.now())
    }

    /// Sets the fixed layout for subsequent resets.
    pub fn set_layout(&mut self, layout: Layout) {
        self.simulation.set_layout(layout);
    }

    /// Sets the perturbations for subsequent resets.
    pub fn set_reality(&mut self, reality: Reality) {
        self.simulation.set_reality(reality);
    }

    /// Sets the duration of moves commanded through `/action`, in nanoseconds of wall-clock time; 0
    /// executes them at once.
    pub fn set_motion_time(&mut self, nanoseconds: u64) {
        self.motion_time = nanoseconds;
    }

    /// Sets the wall-clock time, in nanoseconds since the start. From then on, simulated time
    /// follows it.
    pub fn set_wall_time(&mut self, nanoseconds: u64) {
        self.time.set_wall_time(nanoseconds);
    }

    /// Returns the current image, stamped with the simulated time.
    pub fn image(&self) -> Image {
        messages::image(&self.simulation, self.frame, self.now())
    }

    /// Returns whether the current image is lost on its way from the camera.
    pub fn is_image_dropped(&self) -> bool {
        self.simulation.is_dropped(self.frame)
    }

    /// Advances the simulated time without a step, and takes another image.
    pub fn take_image(&mut self) {
        self.time.advance();
        self.frame = self.frame.wrapping_add(1).max(1);
    }

    /// Returns the end of the move in progress, in nanoseconds of wall-clock time.
    pub fn motion_end(&self) -> Option<u64> {
        self.motion.as_ref().map(|motion| motion.end)
    }

    /// Completes the move in progress if its end has been reached. Returns the status to publish.
    pub fn finish_motion(&mut self) -> Option<EpisodeStatus> {
        let now = self.time.wall_time()?;
        let motion = self.motion.take_if(|motion| now >= motion.end)?;
        // The episode is not over, because nothing else moves the robot during the move.
        self.execute(motion.action, Control::Topic).ok()
    }

    /// Starts the next episode without a request, with the simulator's own random state.
    ///
    /// # Errors
    ///
    /// Returns a message if the fixed layout is invalid in the scenario. Nothing changes in that
    /// case.
    pub fn next_episode(&mut self, scenario: Scenario) -> Result<EpisodeStatus, String> {
        self.simulation.reset(None, Some(scenario)).map_err(|error| error.to_string())?;
        Ok(self.begin_episode(0))
    }

    /// Returns the number of the current episode: the upper 32 bits identify the run of the
    /// simulator, the lower 32 bits count its episodes from 1.
    pub fn episode_number(&self) -> u64 {
        u64::from(self.simulator.get()) << 32 | u64::from(self.episode)
    }

    /// Executes a `/reset` request. `default_scenario` applies if the request has no scenario.
    pub fn reset(
        &mut self,
        client: ClientId,
        request: &reset::Request,
        default_scenario: Scenario,
    ) -> (reset::Response, Option<EpisodeStatus>) {
        if let Some(stored) = self.resets.stored_response(client, request, self.world().steps()) {
            let refused = |message| self.refused_reset((status::SUPERSEDED, message));
            return (stored.unwrap_or_else(refused), None);
        }
        let scenario = match request.scenario.as_str() {
            "" => Ok(default_scenario),
            name => name.parse::<Scenario>().map_err(|error| error.to_string()),
        };
        let result = scenario.and_then(|scenario| {
            let seed = NonZeroU64::new(request.seed);
            self.simulation.reset(seed, Some(scenario)).map_err(|error| error.to_string())
        });
        if let Err(message) = result {
            return (self.refused_reset((status::INVALID_SCENARIO, message)), None);
        }
        let executed = self.begin_episode(request.seed);
        let response = reset::Response {
            success: true,
            status: status::OK,
            message: String::new(),
            episode: self.episode_number(),
            image: self.image(),
        };
        self.resets.store(client, request, &response);
        (response, Some(executed))
    }

    fn refused_reset(&self, (status, message): Refusal) -> reset::Response {
        let episode = self.episode_number();
        reset::Response { success: false, status, message, episode, image: Image::default() }
    }

    /// Executes a `/step` request.
    pub fn step(&mut self, request: &step::Request) -> (step::Response, Option<EpisodeStatus>) {
        self.try_step(request).unwrap_or_else(|refusal| (self.refused_step(refusal), None))
    }

    /// Returns the response that refuses a `/step` request during a move.
    pub fn busy(&self) -> step::Response {
        let step = self.world().steps() + 1;
        let message = format!("the robot is still executing step {step}");
        self.refused_step((status::OUT_OF_ORDER, message))
    }

    fn refused_step(&self, (status, message): Refusal) -> step::Response {
        step::Response {
            status,
            message,
            episode: self.episode_number(),
            step: self.world().steps(),
            ..step::Response::default()
        }
    }

    /// Returns whether a `/step` request would move the robot, that is, whether it is neither
    /// refused nor a duplicate.
    pub fn is_move(&self, request: &step::Request) -> bool {
        matches!(self.classify(request), Ok(Verdict::Move { .. }))
    }

    fn try_step(
        &mut self,
        request: &step::Request,
    ) -> Result<(step::Response, Option<EpisodeStatus>), Refusal> {
        let (action, number) = match self.classify(request)? {
            Verdict::Duplicate(stored) => {
                // Nothing has moved since the step, so the image has not changed.
                let stamp = messages::stamp(self.time.last_change());
                let image = messages::image(&self.simulation, 0, stamp);
                return Ok((step::Response { image, ..stored }, None));
            }
            Verdict::Move { action, number } => (action, number),
        };
        let executed = self.execute(action, Control::Service)?;
        let response = step::Response {
            success: true,
            status: status::OK,
            reward: executed.reward,
            terminated: executed.terminated,
            truncated: executed.truncated,
            blocked: executed.blocked,
            episode: self.episode_number(),
            step: number,
            ..step::Response::default()
        };
        self.latest_step = Some((request.action, response.clone()));
        Ok((step::Response { image: self.image(), ..response }, Some(executed)))
    }

    /// Classifies a `/step` request, or returns why it is refused.
    fn classify(&self, request: &step::Request) -> Result<Verdict, Refusal> {
        let action = action(request.action)?;
        self.check_episode(request.episode)?;
        self.check_control(Control::Service)?;
        let executed = self.world().steps();
        let number = if request.step == 0 { executed + 1 } else { request.step };
        if let (true, Some((latest, response))) = (number == executed, &self.latest_step) {
            let action = request.action;
            return match *latest == action {
                true => Ok(Verdict::Duplicate(response.clone())),
                false => Err((
                    status::ACTION_DIFFERS,
                    format!("step {number} was executed with action {latest}, not {action}"),
                )),
            };
        }
        self.check_not_over(number)?;
        if number != executed + 1 {
            let next = executed + 1;
            let message = format!("step {number} is out of order: the next step is {next}");
            return Err((status::OUT_OF_ORDER, message));
        }
        Ok(Verdict::Move { action, number })
    }

    /// Executes an `/action` command. Returns the status to publish, or `None` if the command
    /// starts a move that takes time or was sent through the service.
    ///
    /// # Errors
    ///
    /// Returns a message if the command is refused. Nothing changes in that case.
    pub fn command(&mut self, command: &ActionCommand) -> Result<Option<EpisodeStatus>, String> {
        if command.sent_by_service {
            return Ok(None);
        }
        let execute = |session: &mut Session| {
            let action = action(command.action)?;
            session.check_control(Control::Topic)?;
            session.check_not_over(session.world().steps() + 1)?;
            session.check_current(command.header.stamp)?;
            if session.motion_time == 0 {
                return Ok(Some(session.execute(action, Control::Topic)?));
            }
            let now = session.time.wall_time().unwrap_or(session.time.now());
            session.motion = Some(Motion { action, end: now + session.motion_time });
            session.control = Some(Control::Topic);
            Ok(None)
        };
        execute(self).map_err(|(_, message): Refusal| message)
    }

    /// Refuses a command that arrives during a move or whose image is older than the end of
    /// the last move or reset. A manual command, which has stamp 0, is refused only during a move.
    fn check_current(&self, stamp: Time) -> Result<(), Refusal> {
        let seconds = |nanoseconds: u64| nanoseconds as f64 / 1e9;
        if let Some(motion) = &self.motion {
            let end = seconds(motion.end);
            let message = format!("the robot is moving until {end:.3} s; wait for the next image");
            return Err((status::OUT_OF_ORDER, message));
        }
        let image = messages::nanoseconds(stamp);
        let last_change = self.time.last_change();
        if image != 0 && image < last_change {
            let (image, last_change) = (seconds(image), seconds(last_change));
            let message = format!(
                "outdated image: stamp {image:.3} s (expected: at least {last_change:.3} s, the \
                 end of the last move or reset)"
            );
            return Err((status::OUT_OF_ORDER, message));
        }
        Ok(())
    }

    fn check_episode(&self, number: u64) -> Result<(), Refusal> {
        let current = self.episode_number();
        let (simulator, episode) = (upper_half(number), number as u32);
        if number == 0 || number == current {
            Ok(())
        } else if simulator.is_some_and(|simulator| simulator != self.simulator) {
            let message = format!(
                "episode {number} belongs to another run: the simulator was restarted (current \
                 episode: {current})"
            );
            Err((status::SIMULATOR_RESTARTED, message))
        } else if simulator == Some(self.simulator) && (1..self.episode).contains(&episode) {
            let message = format!(
                "episode {number} was replaced by a later reset (current episode: {current})"
            );
            Err((status::SUPERSEDED, message))
        } else {
            let message = format!("episode {number} never existed (current episode: {current})");
            Err((status::UNKNOWN_EPISODE, message))
        }
    }

    fn check_control(&self, control: Control) -> Result<(), Refusal> {
        match self.control {
            Some(current) if current != control => {
                let interface = match current {
                    Control::Service => "the /step service",
                    Control::Topic => "the /action topic",
                };
                let message = format!("{interface} controls the robot until the next reset");
                Err((status::SUPERSEDED, message))
            }
            _ => Ok(()),
        }
    }

    fn check_not_over(&self, number: u32) -> Result<(), Refusal> {
        match self.world().is_over() && number > self.world().steps() {
            true => {
                let steps = self.world().steps();
                let message =
                    format!("the episode ended at step {steps}; reset to start the next one");
                Err((status::EPISODE_OVER, message))
            }
            false => Ok(()),
        }
    }

    fn execute(&mut self, action: Action, control: Control) -> Result<EpisodeStatus, Refusal> {
        let outcome = self
            .simulation
            .step(action)
            .map_err(|over| (status::EPISODE_OVER, over.to_string()))?;
        self.control = Some(control);
        let status = EpisodeStatus {
            action: action.index(),
            reward: outcome.reward,
            terminated: outcome.terminated,
            truncated: outcome.truncated,
            blocked: outcome.blocked,
            ..EpisodeStatus::default()
        };
        Ok(self.commit(status))
    }

    fn begin_episode(&mut self, seed: u64) -> EpisodeStatus {
        // Wraps around to 1 after 2^32 - 1 episodes.
        self.episode = self.episode.checked_add(1).unwrap_or(1);
        self.seed = seed;
        self.control = None;
        self.latest_step = None;
        self.motion = None;
        self.path.clear();
        self.commit(EpisodeStatus { action: EpisodeStatus::NONE, ..EpisodeStatus::default() })
    }

    /// Advances the time after a step or reset, extends the path, and completes the status.
    fn commit(&mut self, status: EpisodeStatus) -> EpisodeStatus {
        self.time.advance();
        self.time.record_change();
        self.frame = 0;
        self.path.push(StampedPose { time: self.time.now(), pose: *self.world().robot() });
        EpisodeStatus {
            header: Header { stamp: self.now(), frame_id: String::new() },
            episode: self.episode_number(),
            scenario: self.world().scenario().name().to_owned(),
            seed: self.seed,
            step: self.world().steps(),
            ..status
        }
    }
}

fn action(index: u8) -> Result<Action, Refusal> {
    Action::try_from(index).map_err(|error| (status::INVALID_ACTION, error.to_string()))
}

#[cfg(test)]
mod tests;
