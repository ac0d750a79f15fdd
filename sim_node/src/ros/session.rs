//! Who may do what with the room, and when: the rules of `/reset`, `/step` and `/action`.
//!
//! Requests may be lost, repeated, late, or somebody else's. Numbers tell them apart: a client
//! numbers its resets, the simulator its episodes, and an episode its steps. A request that was
//! executed before is answered as before and executes nothing; one that fits nowhere is refused and
//! changes nothing. No DDS here: messages in, messages out.

mod reset_ledger;
mod timeline;

use std::num::{NonZeroU32, NonZeroU64};

use evac_msgs::{ActionCommand, EpisodeStatus, reset, status, step};
use nalgebra::Isometry2;
use rand::RngExt;
use ros_interfaces::{builtin_interfaces::Time, sensor_msgs::Image, std_msgs::Header};
use task::{Action, Scenario};

use self::{
    reset_ledger::{ResetLedger, upper_half},
    timeline::Timeline,
};
use super::messages;
use crate::{
    camera::Camera,
    world::{Layout, World},
};

/// A client, as DDS identifies it.
pub type ClientId = [u8; 16];

/// How many steps of an episode find room in the path from the start, so that none of them waits for
/// memory: as many as an episode usually has at most.
const PATH_CAPACITY: u32 = 10_000;

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
    time: Timeline,
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
    resets: ResetLedger,
    /// The latest action and its answer, whose image is left out: the room still shows it.
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
    pub fn new(world: World, camera: Camera, step_duration: f64) -> (Session, EpisodeStatus) {
        Session::numbered(rand::rng().random(), world, camera, step_duration)
    }

    /// As [`Session::new`], with the upper half of the episodes' numbers, which must not be that of
    /// an earlier start.
    pub fn numbered(
        simulator: NonZeroU32,
        world: World,
        camera: Camera,
        step_duration: f64,
    ) -> (Session, EpisodeStatus) {
        let mut session = Session {
            path: Vec::with_capacity(world.max_steps().min(PATH_CAPACITY) as usize + 1),
            world,
            camera,
            time: Timeline::new(step_duration),
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
        messages::stamp(self.time.now())
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
        self.time.follow(nanoseconds);
    }

    /// What the camera sees now, with the stamp of the present time.
    pub fn image(&self) -> Image {
        messages::image(&self.camera, &self.world, self.now())
    }

    /// Lets time pass between steps, for an image that is sent once more.
    pub fn pass_time(&mut self) {
        self.time.pass();
    }

    /// When the move under way ends, by the clock on the wall.
    pub fn motion_end(&self) -> Option<u64> {
        self.motion.as_ref().map(|motion| motion.end)
    }

    /// Ends the move under way, if its time has come.
    pub fn finish_motion(&mut self) -> Option<EpisodeStatus> {
        let motion =
            self.motion.take_if(|motion| self.time.wall().is_some_and(|now| now >= motion.end))?;
        // The episode is not over: nothing else moves the robot meanwhile.
        self.execute(motion.action, Control::Topic).ok()
    }

    /// Begins another episode, as a reset by nobody does that has no seed.
    pub fn next_episode(&mut self, scenario: Scenario) -> Result<EpisodeStatus, String> {
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
    ) -> (reset::Response, Option<EpisodeStatus>) {
        if let Some(answer) = self.resets.answered(client, request, self.world.steps()) {
            let refused = |message| self.refused_reset((status::SUPERSEDED, message));
            return (answer.unwrap_or_else(refused), None);
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
            image: self.image(),
        };
        self.resets.note(client, request, &response);
        (response, Some(executed))
    }

    fn refused_reset(&self, (status, message): Refusal) -> reset::Response {
        let episode = self.episode_number();
        reset::Response { success: false, status, message, episode, image: Image::default() }
    }

    /// Answers `/step`.
    pub fn step(&mut self, request: &step::Request) -> (step::Response, Option<EpisodeStatus>) {
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
    ) -> Result<(step::Response, Option<EpisodeStatus>), Refusal> {
        let (action, number) = match self.judge(request)? {
            Judgement::Repetition(stored) => {
                // Nothing has moved since: the room is as it was, and the stamp that of the step.
                let stamp = messages::stamp(self.time.settled());
                let image = messages::image(&self.camera, &self.world, stamp);
                return Ok((step::Response { image, ..stored }, None));
            }
            Judgement::Move { action, number } => (action, number),
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
    pub fn command(&mut self, command: &ActionCommand) -> Result<Option<EpisodeStatus>, String> {
        if command.sent_by_service {
            return Ok(None);
        }
        let execute = |session: &mut Session| {
            let action = action(command.action)?;
            session.check_control(Control::Topic)?;
            session.check_not_over(session.world.steps() + 1)?;
            session.check_up_to_date(command.header.stamp)?;
            if session.motion_time == 0 {
                return Ok(Some(session.execute(action, Control::Topic)?));
            }
            let now = session.time.wall().unwrap_or(session.time.now());
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
        let settled = self.time.settled();
        if answered != 0 && answered < settled {
            let (answered, settled) = (seconds(answered), seconds(settled));
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

    fn execute(&mut self, action: Action, control: Control) -> Result<EpisodeStatus, Refusal> {
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
        Ok(self.observe(status))
    }

    fn begin_episode(&mut self, seed: u64) -> EpisodeStatus {
        // After 2^32 episodes the numbers start again at 1.
        self.episode = self.episode.checked_add(1).unwrap_or(1);
        self.seed = seed;
        self.control = None;
        self.latest_step = None;
        self.motion = None;
        self.path.clear();
        self.observe(EpisodeStatus { action: EpisodeStatus::NONE, ..EpisodeStatus::default() })
    }

    /// Lets the time of a step or reset pass: what there is to see now is new.
    fn observe(&mut self, status: EpisodeStatus) -> EpisodeStatus {
        self.time.pass();
        self.time.settle();
        self.path.push(Visit { time: self.time.now(), pose: *self.world.robot() });
        EpisodeStatus {
            header: Header { stamp: self.now(), frame_id: String::new() },
            episode: self.episode_number(),
            scenario: self.world.scenario().name().to_owned(),
            seed: self.seed,
            step: self.world.steps(),
            ..status
        }
    }
}

fn action(index: u8) -> Result<Action, Refusal> {
    Action::try_from(index).map_err(|error| (status::INVALID_ACTION, error.to_string()))
}

#[cfg(test)]
mod tests;
