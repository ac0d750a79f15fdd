//! Who may do what with the room, and when: the rules of `/reset`, `/step` and `/action`.
//!
//! Requests may be lost, repeated, late, or somebody else's. Numbers tell them apart: a client
//! numbers its resets, the simulator its episodes, and an episode its steps. A request that was
//! executed before is answered as before and executes nothing; one that fits nowhere is refused and
//! changes nothing. No DDS here: messages in, messages out.

use std::{
    collections::VecDeque,
    num::{NonZeroU32, NonZeroU64},
};

use evac_msgs::{ActionCommand, EpisodeStatus, reset, status, step};
use nalgebra::Isometry2;
use rand::RngExt;
use ros_interfaces::{builtin_interfaces::Time, sensor_msgs::Image, std_msgs::Header};
use task::{Action, Scenario};

use super::messages;
use crate::{
    camera::Camera,
    world::{Layout, Outcome, World},
};

/// A client, as DDS identifies it.
pub type ClientId = [u8; 16];

/// How many clients' latest resets are remembered. Who returns after so many others is a new one.
const NUMBERINGS: usize = 64;

/// How many steps of an episode find room in the path from the start, so that none of them waits for
/// memory: as many as an episode usually has at most.
const PATH_CAPACITY: u32 = 10_000;

/// What was executed, for those who watch.
#[derive(Clone, Debug, PartialEq)]
pub struct Executed {
    /// What the camera sees now.
    pub image: Image,
    /// What happened.
    pub status: EpisodeStatus,
}

/// Where the robot was, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// Nanoseconds since the start.
    pub time: u64,
    /// The pose of the robot's centre.
    pub pose: Isometry2<f64>,
}

/// A room, its episode, and what was asked of it so far.
#[derive(Clone)]
pub struct Session {
    world: World,
    camera: Camera,
    /// Nanoseconds that a step or a reset takes.
    step_duration: u64,
    /// Nanoseconds since the start.
    time: u64,
    /// What a clock on the wall says, where the time of the simulation follows it.
    wall: Option<u64>,
    /// Since when everything stands where it stands now.
    settled: u64,
    /// How long a move by `/action` takes, in nanoseconds.
    motion_time: u64,
    motion: Option<Motion>,
    /// The upper half of this simulator's episode numbers; 0 marks those that no simulator gave.
    simulator: NonZeroU32,
    /// The lower half of the present one's.
    episode: u32,
    seed: u64,
    /// The pose that the episode began with, and that after each step.
    path: Vec<Visit>,
    control: Option<Control>,
    /// Who has numbered resets, and the latest number of each.
    numberings: VecDeque<(Numbering, u64)>,
    latest_reset: Option<LatestReset>,
    latest_step: Option<(u8, step::Response)>,
}

/// A move that takes its time.
#[derive(Clone)]
struct Motion {
    action: Action,
    /// When it ends, by the clock on the wall.
    end: u64,
}

/// What moves the robot in an episode: whoever came first.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Control {
    Service,
    Topic,
}

/// Whose numbers those of a reset are.
#[derive(Clone, Copy, PartialEq)]
enum Numbering {
    /// Small numbers are the client's own.
    Client(ClientId),
    /// A program draws the upper half of its numbers. It may have to ask again by a new client, and is
    /// still the same to the room.
    Drawn(NonZeroU32),
}

#[derive(Clone)]
struct LatestReset {
    numbering: Numbering,
    request: reset::Request,
    response: reset::Response,
}

/// What a request of `/step` is, if it is not refused.
enum Judgement {
    /// One that was answered before, so.
    Repetition(step::Response),
    /// The next step.
    Move { action: Action, number: u32 },
}

/// Why a request is not executed: a status, and what to tell the client.
type Refusal = (u8, String);

impl Session {
    /// A session at its first episode, which nobody asked for; its image is the first to publish.
    ///
    /// `step_duration` is the simulated time of a step in seconds.
    pub fn new(world: World, camera: Camera, step_duration: f64) -> (Session, Executed) {
        Session::numbered(rand::rng().random(), world, camera, step_duration)
    }

    /// As [`Session::new`], with the upper half of the episodes' numbers, which must not be that of
    /// an earlier start.
    pub fn numbered(
        simulator: NonZeroU32,
        world: World,
        camera: Camera,
        step_duration: f64,
    ) -> (Session, Executed) {
        let mut session = Session {
            path: Vec::with_capacity(world.max_steps().min(PATH_CAPACITY) as usize + 1),
            world,
            camera,
            step_duration: (step_duration * 1e9).round() as u64,
            time: 0,
            wall: None,
            settled: 0,
            motion_time: 0,
            motion: None,
            simulator,
            episode: 0,
            seed: 0,
            control: None,
            numberings: VecDeque::new(),
            latest_reset: None,
            latest_step: None,
        };
        let first = session.begin_episode(0);
        (session, first)
    }

    /// The scenario of the present episode.
    pub fn scenario(&self) -> Scenario {
        self.world.scenario()
    }

    /// The room as it is now.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Where the robot has been in the present episode: at its start, and after each step.
    pub fn path(&self) -> &[Visit] {
        &self.path
    }

    /// The time of the simulation, which is the stamp of the latest image.
    pub fn now(&self) -> Time {
        messages::stamp(self.time)
    }

    /// Holds something else fixed from the next reset on.
    pub fn set_layout(&mut self, layout: Layout) {
        self.world.set_layout(layout);
    }

    /// Lets moves by `/action` take so many nanoseconds, by the clock of [`Session::set_wall_time`].
    pub fn set_motion_time(&mut self, nanoseconds: u64) {
        self.motion_time = nanoseconds;
    }

    /// From now on the time of the simulation follows a clock on the wall, which says so many
    /// nanoseconds since the start.
    pub fn set_wall_time(&mut self, nanoseconds: u64) {
        self.wall = Some(nanoseconds);
    }

    /// The present image once more, with a new stamp.
    pub fn frame(&mut self) -> Image {
        self.pass_time();
        messages::image(&self.camera.render(&self.world), self.now())
    }

    /// When the move under way ends, by the clock on the wall.
    pub fn motion_end(&self) -> Option<u64> {
        self.motion.as_ref().map(|motion| motion.end)
    }

    /// Ends the move under way, if its time has come.
    pub fn finish_motion(&mut self) -> Option<Executed> {
        let motion =
            self.motion.take_if(|motion| self.wall.is_some_and(|now| now >= motion.end))?;
        // The episode is not over: nothing else moves the robot meanwhile.
        self.execute(motion.action, Control::Topic).ok().map(|(_, executed)| executed)
    }

    /// Begins another episode, as a reset by nobody does that has no seed.
    pub fn next_episode(&mut self, scenario: Scenario) -> Result<Executed, String> {
        self.world.reset(None, Some(scenario)).map_err(|error| error.to_string())?;
        Ok(self.begin_episode(0))
    }

    /// The number of the present episode.
    pub fn episode_number(&self) -> u64 {
        u64::from(self.simulator.get()) << 32 | u64::from(self.episode)
    }

    /// Answers `/reset`. `default_scenario` is for requests that name none.
    pub fn reset(
        &mut self,
        client: ClientId,
        request: &reset::Request,
        default_scenario: Scenario,
    ) -> (reset::Response, Option<Executed>) {
        if let Some(answer) = self.repeated_reset(client, request) {
            return (answer.unwrap_or_else(|refusal| self.refused_reset(refusal)), None);
        }
        let scenario = match request.scenario.as_str() {
            "" => Ok(default_scenario),
            name => name.parse::<Scenario>().map_err(|error| error.to_string()),
        };
        let placed = scenario.and_then(|scenario| {
            let seed = NonZeroU64::new(request.seed);
            self.world.reset(seed, Some(scenario)).map_err(|error| error.to_string())
        });
        if let Err(reason) = placed {
            return (self.refused_reset((status::INVALID_SCENARIO, reason)), None);
        }
        let executed = self.begin_episode(request.seed);
        let response = reset::Response {
            success: true,
            status: status::OK,
            message: String::new(),
            episode: self.episode_number(),
            image: executed.image.clone(),
        };
        self.remember_reset(client, request, &response);
        (response, Some(executed))
    }

    /// The stored answer to a reset that was executed before, or why it cannot be given.
    fn repeated_reset(
        &self,
        client: ClientId,
        request: &reset::Request,
    ) -> Option<Result<reset::Response, Refusal>> {
        if request.request == 0 {
            return None;
        }
        let numbering = Numbering::of(client, request.request);
        if let Some(latest) = &self.latest_reset {
            // By hand each call is a client of its own: there the whole request must be the same, and
            // nothing have happened since.
            let same_number =
                latest.numbering == numbering && latest.request.request == request.request;
            let by_hand = latest.request == *request && self.world.steps() == 0;
            if same_number || by_hand {
                return Some(Ok(latest.response.clone()));
            }
        }
        let (_, latest) = self.numberings.iter().find(|(known, _)| *known == numbering)?;
        let number = request.request;
        (number <= *latest).then(|| {
            let message = match number == *latest {
                true => format!("another client has reset the room since your request {number}"),
                false => format!("request {number} is older than your latest, {latest}"),
            };
            Err((status::SUPERSEDED, message))
        })
    }

    fn remember_reset(
        &mut self,
        client: ClientId,
        request: &reset::Request,
        response: &reset::Response,
    ) {
        self.latest_reset = None;
        if request.request != 0 {
            let numbering = Numbering::of(client, request.request);
            self.numberings.retain(|(known, _)| *known != numbering);
            self.numberings.push_back((numbering, request.request));
            if self.numberings.len() > NUMBERINGS {
                self.numberings.pop_front();
            }
            let (request, response) = (request.clone(), response.clone());
            self.latest_reset = Some(LatestReset { numbering, request, response });
        }
    }

    fn refused_reset(&self, (status, message): Refusal) -> reset::Response {
        let episode = self.episode_number();
        reset::Response { success: false, status, message, episode, image: Image::default() }
    }

    /// Answers `/step`.
    pub fn step(&mut self, request: &step::Request) -> (step::Response, Option<Executed>) {
        self.try_step(request).unwrap_or_else(|refusal| (self.refused_step(refusal), None))
    }

    /// The answer to a request that comes while the robot carries out another one.
    pub fn busy(&self) -> step::Response {
        let step = self.world.steps() + 1;
        self.refused_step((
            status::OUT_OF_ORDER,
            format!("the robot is moving: it takes step {step}"),
        ))
    }

    fn refused_step(&self, (status, message): Refusal) -> step::Response {
        step::Response {
            status,
            message,
            episode: self.episode_number(),
            step: self.world.steps(),
            ..step::Response::default()
        }
    }

    /// Whether a request of `/step` would move the robot now: it is neither refused nor a repetition.
    pub fn is_move(&self, request: &step::Request) -> bool {
        matches!(self.judge(request), Ok(Judgement::Move { .. }))
    }

    fn try_step(
        &mut self,
        request: &step::Request,
    ) -> Result<(step::Response, Option<Executed>), Refusal> {
        let (action, number) = match self.judge(request)? {
            Judgement::Repetition(response) => return Ok((response, None)),
            Judgement::Move { action, number } => (action, number),
        };
        let (outcome, executed) = self.execute(action, Control::Service)?;
        let response = step::Response {
            success: true,
            status: status::OK,
            message: String::new(),
            image: executed.image.clone(),
            reward: outcome.reward,
            terminated: outcome.terminated,
            truncated: outcome.truncated,
            blocked: outcome.blocked,
            episode: self.episode_number(),
            step: number,
        };
        self.latest_step = Some((request.action, response.clone()));
        Ok((response, Some(executed)))
    }

    /// What a request of `/step` is, or why it is refused.
    fn judge(&self, request: &step::Request) -> Result<Judgement, Refusal> {
        let action = action(request.action)?;
        self.check_episode(request.episode)?;
        self.check_control(Control::Service)?;
        let taken = self.world.steps();
        let number = if request.step == 0 { taken + 1 } else { request.step };
        if let (true, Some((latest, response))) = (number == taken, &self.latest_step) {
            return match *latest == request.action {
                true => Ok(Judgement::Repetition(response.clone())),
                false => Err((
                    status::ACTION_DIFFERS,
                    format!("step {number} was taken with action {latest}, not {}", request.action),
                )),
            };
        }
        self.check_not_over(number)?;
        if number != taken + 1 {
            let next = taken + 1;
            let message = format!("step {number} is out of order: the next step is {next}");
            return Err((status::OUT_OF_ORDER, message));
        }
        Ok(Judgement::Move { action, number })
    }

    /// Obeys `/action`: what was executed, nothing if the command is only for those who watch, or
    /// why it is refused.
    pub fn command(&mut self, command: &ActionCommand) -> Result<Option<Executed>, String> {
        if command.sent_by_service {
            return Ok(None);
        }
        let execute = |session: &mut Session| {
            let action = action(command.action)?;
            session.check_control(Control::Topic)?;
            session.check_not_over(session.world.steps() + 1)?;
            session.check_up_to_date(command.header.stamp)?;
            if session.motion_time == 0 {
                return Ok(Some(session.execute(action, Control::Topic)?.1));
            }
            let now = session.wall.unwrap_or(session.time);
            session.motion = Some(Motion { action, end: now + session.motion_time });
            session.control = Some(Control::Topic);
            Ok(None)
        };
        execute(self).map_err(|(_, message): Refusal| message)
    }

    /// A command answers an image: not one that was taken before things stood as they do, and none
    /// while the robot moves. A stamp of zero is somebody's by hand.
    fn check_up_to_date(&self, stamp: Time) -> Result<(), Refusal> {
        let seconds = |nanoseconds: u64| nanoseconds as f64 / 1e9;
        if let Some(motion) = &self.motion {
            let end = seconds(motion.end);
            let message = format!("the robot is moving until {end:.3} s: wait for its image then");
            return Err((status::OUT_OF_ORDER, message));
        }
        let answered = messages::nanoseconds(stamp);
        if answered != 0 && answered < self.settled {
            let (answered, settled) = (seconds(answered), seconds(self.settled));
            let message = format!(
                "it answers an image of {answered:.3} s, and since {settled:.3} s the robot is \
                 elsewhere"
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
                "episode {number} is of another start of the simulator: it was restarted, and the \
                 episode is now {current}"
            );
            Err((status::SIMULATOR_RESTARTED, message))
        } else if simulator == Some(self.simulator) && (1..self.episode).contains(&episode) {
            let message = format!("a later reset has replaced episode {number} by {current}");
            Err((status::SUPERSEDED, message))
        } else {
            let message = format!("there never was an episode {number}: it is {current} now");
            Err((status::UNKNOWN_EPISODE, message))
        }
    }

    fn check_control(&self, control: Control) -> Result<(), Refusal> {
        match self.control {
            Some(bound) if bound != control => {
                let way = match bound {
                    Control::Service => "the service step",
                    Control::Topic => "the topic action",
                };
                Err((status::SUPERSEDED, format!("{way} moves the robot until the next reset")))
            }
            _ => Ok(()),
        }
    }

    fn check_not_over(&self, number: u32) -> Result<(), Refusal> {
        match self.world.is_over() && number > self.world.steps() {
            true => {
                let steps = self.world.steps();
                let message =
                    format!("the episode ended with step {steps}: reset to begin another");
                Err((status::EPISODE_OVER, message))
            }
            false => Ok(()),
        }
    }

    fn execute(
        &mut self,
        action: Action,
        control: Control,
    ) -> Result<(Outcome, Executed), Refusal> {
        let outcome =
            self.world.step(action).map_err(|over| (status::EPISODE_OVER, over.to_string()))?;
        self.control = Some(control);
        let status = EpisodeStatus {
            action: action.index(),
            reward: outcome.reward,
            terminated: outcome.terminated,
            truncated: outcome.truncated,
            blocked: outcome.blocked,
            ..EpisodeStatus::default()
        };
        Ok((outcome, self.observe(status)))
    }

    fn begin_episode(&mut self, seed: u64) -> Executed {
        // After 2^32 episodes the numbers start again at 1.
        self.episode = self.episode.checked_add(1).unwrap_or(1);
        self.seed = seed;
        self.control = None;
        self.latest_step = None;
        self.motion = None;
        self.path.clear();
        self.observe(EpisodeStatus { action: EpisodeStatus::NONE, ..EpisodeStatus::default() })
    }

    /// Lets the time of a step or reset pass, or that of the clock on the wall.
    fn pass_time(&mut self) {
        self.time = match self.wall {
            None => self.time.saturating_add(self.step_duration),
            // Two images never have the same stamp.
            Some(now) => now.max(self.time + 1),
        };
    }

    /// Lets the time of a step or reset pass, and takes the picture.
    fn observe(&mut self, status: EpisodeStatus) -> Executed {
        self.pass_time();
        self.settled = self.time;
        self.path.push(Visit { time: self.time, pose: *self.world.robot() });
        let stamp = self.now();
        let image = messages::image(&self.camera.render(&self.world), stamp);
        let status = EpisodeStatus {
            header: Header { stamp, frame_id: String::new() },
            episode: self.episode_number(),
            scenario: self.world.scenario().name().to_owned(),
            seed: self.seed,
            step: self.world.steps(),
            ..status
        };
        Executed { image, status }
    }
}

impl Numbering {
    fn of(client: ClientId, request: u64) -> Numbering {
        upper_half(request).map_or(Numbering::Client(client), Numbering::Drawn)
    }
}

/// Who has given a number, if that is one who draws the upper half.
fn upper_half(number: u64) -> Option<NonZeroU32> {
    NonZeroU32::new((number >> 32) as u32)
}

fn action(index: u8) -> Result<Action, Refusal> {
    Action::try_from(index).map_err(|error| (status::INVALID_ACTION, error.to_string()))
}

#[cfg(test)]
mod tests;
