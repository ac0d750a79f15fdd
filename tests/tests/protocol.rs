//! Exactly once, in every order of events: the protocol of `/reset` and `/step`, explored exhaustively.
//!
//! Both sides are the real ones: the simulator's `Session` and the agent's `Conversation`. Between
//! them is a network that forgets nothing: whatever was ever asked may reach the simulator at any
//! time and any number of times, or never, and so may every answer to what the agent waits for. That
//! is all that loss, repetition, delay, overtaking and asking again can do, without any bound.
//! (Answers to anything else reach nobody: a client knows its answers by the request's identity, and
//! throws others away.) At any time either side may be killed and started again, the agent from a
//! checkpoint in any of its episodes, and the agent may ask by a new client, as it does when a send
//! window is full. Bounded are the work, two episodes of three steps, and how often somebody is
//! killed or a client replaced, twice. Those are some 137,000 states.
//!
//! In every state that can be reached the promises must hold. The last of them is that the training
//! ends, as if nothing had happened, as soon as messages come through.

use std::{
    fmt::{Debug, Formatter},
    hash::{Hash, Hasher},
    num::{NonZeroU32, NonZeroU64},
    sync::Arc,
    thread::available_parallelism,
};

use agent_node::ros::{
    SimulatorError,
    conversation::{AfterStep, Conversation},
};
use evac_msgs::{reset, status, step};
use evac_tests::Room;
use sim_node::{
    camera::{Camera, CameraSettings},
    ros::Session,
    world::{World, WorldSettings},
};
use stateright::{Checker, HasDiscoveries, Model, Property};
use task::{Action, Environment, Image, Scenario, Step};

/// Obstacles move in it: no two steps show the same image, whether the robot moves or not.
const SCENARIO: Scenario = Scenario::ThreeMoving;
/// Of the episodes.
const SEEDS: [u64; 2] = [1, 2];
/// Of every episode: alike, so that nothing but numbers tells the steps apart, and so many that there
/// is one to come when the first is no longer the latest.
const ACTIONS: [u8; 3] = [3, 3, 3];
/// How often at most somebody is killed or a client replaced.
const FAULTS: u32 = 2;

/// More requests than a training needs, with all that is repeated after a restart.
const ENOUGH: usize = 100;

/// A training of a few steps: what the agent sees in each episode if nothing goes wrong, at first and
/// after each step.
struct Training {
    undisturbed: Vec<Vec<Done>>,
}

type Promise = Property<Training>;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Request {
    Reset(reset::Request),
    Step(step::Request),
}

#[derive(Clone, Debug, PartialEq)]
enum Answer {
    Reset(reset::Response),
    Step(step::Response),
}

/// What the agent has begun, and has come to its end.
#[derive(Clone, Debug, PartialEq)]
enum Done {
    Reset(Image),
    Step(Step),
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct State {
    simulator: Simulator,
    agent: Agent,
    /// All that was ever asked.
    requests: Vec<(Client, Request)>,
    /// All answers to what the agent asks now.
    answers: Vec<Letter>,
    /// How often somebody was killed or a client replaced.
    faults: u32,
}

/// A start of the simulator.
#[derive(Clone)]
struct Simulator {
    start: u32,
    /// What it has executed. The session follows from that.
    executed: Vec<(Client, Request)>,
    session: Arc<Session>,
}

/// A start of the agent.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Agent {
    client: Client,
    conversation: Conversation,
    /// The episode, and how many images of it were seen.
    episode: usize,
    seen: usize,
    /// Whether something was seen that an undisturbed training does not show.
    is_deceived: bool,
    activity: Activity,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Activity {
    Asking(Request),
    /// The training is done.
    Ready,
    /// It has stopped: somebody else has reset the room.
    TakenOver,
    /// It has stopped for another reason.
    Failed(String),
}

/// A client as DDS knows it: the first one of a start of the agent, or the one that took its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Client {
    start: u32,
    is_first: bool,
}

#[derive(Clone, PartialEq)]
struct Letter(Answer);

#[derive(Clone, Debug, PartialEq)]
enum Event {
    /// A request reaches the simulator, perhaps once more.
    Request(Client, Request),
    /// An answer reaches the agent.
    Answer(Letter),
    /// The agent asks once more, by a new client.
    NewClient,
    RestartedSimulator,
    /// From a checkpoint in this episode.
    RestartedAgent(usize),
}

impl Training {
    fn new() -> Training {
        let mut room = Room::new(settings());
        let mut episode = |seed| {
            let first = room.reset(seed, SCENARIO.name()).map(Done::Reset);
            let steps = ACTIONS.map(|index| room.step(action(index)));
            let steps = steps.into_iter().map(|step| step.map(Done::Step));
            [first].into_iter().chain(steps).collect::<Result<Vec<Done>, _>>()
        };
        let episodes: Result<Vec<_>, _> = SEEDS.map(seed).into_iter().map(&mut episode).collect();
        let undisturbed = episodes.expect("the room answers");
        let seen: Vec<&Done> = undisturbed.iter().flatten().collect();
        for (index, done) in seen.iter().enumerate() {
            assert!(!seen[..index].contains(done), "a wrong image must be told by its looks");
        }
        Training { undisturbed }
    }
}

impl Model for Training {
    type State = State;
    type Action = Event;

    fn init_states(&self) -> Vec<State> {
        let mut state = State {
            simulator: Simulator::start(1),
            agent: Agent::start(1, 0),
            requests: Vec::new(),
            answers: Vec::new(),
            faults: 0,
        };
        state.ask();
        vec![state]
    }

    fn actions(&self, state: &State, events: &mut Vec<Event>) {
        let requests = state.requests.iter().cloned();
        events.extend(requests.map(|(client, request)| Event::Request(client, request)));
        events.extend(state.answers.iter().cloned().map(Event::Answer));
        if state.faults == FAULTS {
            return;
        }
        let begun = SEEDS.len().min(state.agent.episode + 1);
        events.extend((0..begun).map(Event::RestartedAgent));
        events.push(Event::RestartedSimulator);
        if state.agent.is_resetting() && state.agent.client.is_first {
            events.push(Event::NewClient);
        }
    }

    fn next_state(&self, before: &State, event: Event) -> Option<State> {
        let mut state = before.clone();
        state.faults += u32::from(event.is_fault());
        match event {
            Event::Request(client, request) => {
                let answer = Letter(state.simulator.answer(client, &request));
                if state.is_awaited(client, &request) && !state.answers.contains(&answer) {
                    state.answers.push(answer);
                }
            }
            Event::Answer(Letter(answer)) => {
                state.agent.hear(answer, self);
                state.ask();
            }
            Event::NewClient => {
                state.agent.client.is_first = false;
                state.ask();
            }
            Event::RestartedSimulator => {
                state.simulator = Simulator::start(state.simulator.start + 1);
            }
            Event::RestartedAgent(episode) => {
                state.agent = Agent::start(state.agent.client.start + 1, episode);
                state.ask();
            }
        }
        (state != *before).then_some(state)
    }

    fn properties(&self) -> Vec<Promise> {
        vec![
            Promise::always("a request is executed once, and in its order", |_, state| {
                state.simulator.executes_once_and_in_order()
            }),
            Promise::always(
                "both agree on episode and step, or say that they do not",
                |_, state| state.both_agree_or_say_so(),
            ),
            Promise::always("the agent sees what an undisturbed training shows", |_, state| {
                !state.agent.is_deceived
            }),
            Promise::always("only what a killed agent asked can stop an agent", |_, state| {
                match state.agent.activity {
                    Activity::Failed(_) => false,
                    Activity::TakenOver => state.agent.client.start > 1,
                    Activity::Asking(_) | Activity::Ready => true,
                }
            }),
            Promise::always("the training ends once messages come through", |training, state| {
                state.ends_undisturbed(training)
            }),
            // What else is there to see, so that the promises are not kept for want of events?
            Promise::sometimes("a training ends although both were killed", |_, state| {
                let both = state.simulator.start > 1 && state.agent.client.start > 1;
                both && state.agent.activity == Activity::Ready
            }),
            Promise::sometimes("a killed agent's reset stops the next one", |_, state| {
                state.agent.activity == Activity::TakenOver
            }),
        ]
    }
}

impl Event {
    fn is_fault(&self) -> bool {
        match self {
            Event::Request(..) | Event::Answer(_) => false,
            Event::NewClient | Event::RestartedSimulator | Event::RestartedAgent(_) => true,
        }
    }
}

impl State {
    /// Lets the network know what the agent asks now. Answers to anything else reach nobody.
    fn ask(&mut self) {
        if let Activity::Asking(request) = &self.agent.activity {
            self.requests.push((self.agent.client, request.clone()));
        }
        self.answers.clear();
    }

    fn is_awaited(&self, client: Client, request: &Request) -> bool {
        client.start == self.agent.client.start
            && matches!(&self.agent.activity, Activity::Asking(awaited) if awaited == request)
    }

    /// Of a step that the agent waits for: whether it is the simulator's latest or next one and is
    /// answered so, or is refused with an empty image.
    fn both_agree_or_say_so(&self) -> bool {
        let Activity::Asking(Request::Step(request)) = &self.agent.activity else {
            return true;
        };
        let mut session = Session::clone(&self.simulator.session);
        let (number, steps) = (session.episode_number(), session.world().steps());
        let (response, _) = session.step(request);
        if number == request.episode {
            (steps == request.step || steps + 1 == request.step)
                && response.status == status::OK
                && (response.episode, response.step) == (number, request.step)
        } else {
            response.status != status::OK
                && response.image == ros_interfaces::sensor_msgs::Image::default()
        }
    }

    /// Whether the training ends, and as if nothing had happened, if from now on every request is
    /// answered at once. An agent that was stopped is started again, once.
    fn ends_undisturbed(&self, training: &Training) -> bool {
        let State { mut simulator, mut agent, .. } = self.clone();
        for _ in 0..ENOUGH {
            match agent.activity.clone() {
                Activity::Asking(request) => {
                    agent.hear(simulator.answer(agent.client, &request), training);
                }
                Activity::TakenOver if agent.client.start == self.agent.client.start => {
                    agent = Agent::start(agent.client.start + 1, agent.episode);
                }
                Activity::Ready => return !agent.is_deceived,
                Activity::TakenOver | Activity::Failed(_) => return false,
            }
        }
        false
    }
}

impl Simulator {
    fn start(start: u32) -> Simulator {
        let world = World::new(settings(), SCENARIO, 0).expect("nothing is held fixed");
        let camera = Camera::new(CameraSettings::default()).expect("the default mount is possible");
        let (session, _) = Session::numbered(number(start), world, camera, 0.5);
        Simulator { start, executed: Vec::new(), session: Arc::new(session) }
    }

    fn answer(&mut self, client: Client, request: &Request) -> Answer {
        let session = Arc::make_mut(&mut self.session);
        let (answer, executed) = match request {
            Request::Reset(request) => {
                let (response, executed) = session.reset(client.identity(), request, SCENARIO);
                (Answer::Reset(response), executed)
            }
            Request::Step(request) => {
                let (response, executed) = session.step(request);
                (Answer::Step(response), executed)
            }
        };
        if executed.is_some() {
            self.executed.push((client, request.clone()));
        }
        answer
    }

    fn executes_once_and_in_order(&self) -> bool {
        // The first episode is the simulator's own.
        let (mut episode, mut taken) = (u64::from(self.start) << 32 | 1, 0);
        self.executed.iter().enumerate().all(|(index, (_, request))| match request {
            Request::Reset(_) => {
                (episode, taken) = (episode + 1, 0);
                self.executed[..index].iter().all(|(_, earlier)| earlier != request)
            }
            Request::Step(step) => {
                taken += 1;
                (step.episode, step.step) == (episode, taken)
            }
        })
    }
}

impl Agent {
    fn start(start: u32, episode: usize) -> Agent {
        let mut conversation = Conversation::new(number(start));
        let request = conversation.begin_episode(seed(SEEDS[episode]), SCENARIO.name());
        let request = Request::Reset(request);
        Agent {
            client: Client { start, is_first: true },
            conversation,
            episode,
            seen: 0,
            is_deceived: false,
            activity: Activity::Asking(request),
        }
    }

    fn is_resetting(&self) -> bool {
        matches!(self.activity, Activity::Asking(Request::Reset(_)))
    }

    fn hear(&mut self, answer: Answer, training: &Training) {
        self.activity = match self.next(answer, training) {
            Ok(Some(request)) => Activity::Asking(request),
            Ok(None) => Activity::Ready,
            Err(SimulatorError::TakenOver(_)) => Activity::TakenOver,
            Err(error) => Activity::Failed(error.to_string()),
        };
    }

    /// What to ask after an answer; none if the training is done.
    fn next(
        &mut self,
        answer: Answer,
        training: &Training,
    ) -> Result<Option<Request>, SimulatorError> {
        let done = match answer {
            Answer::Reset(response) if self.seen == 0 => {
                Done::Reset(self.conversation.begun(response)?)
            }
            Answer::Reset(response) => {
                return Ok(Some(Request::Step(self.conversation.repeated(response)?)));
            }
            Answer::Step(response) => match self.conversation.stepped(response)? {
                AfterStep::Done(step) => Done::Step(step),
                AfterStep::Step(request) => return Ok(Some(Request::Step(request))),
                AfterStep::Reset(request) => return Ok(Some(Request::Reset(request))),
            },
        };
        self.is_deceived |= done != training.undisturbed[self.episode][self.seen];
        self.seen += 1;
        if let Some(index) = ACTIONS.get(self.seen - 1) {
            return Ok(Some(Request::Step(self.conversation.begin_step(action(*index))?)));
        }
        (self.episode, self.seen) = (self.episode + 1, 0);
        let Some(next) = SEEDS.get(self.episode) else {
            return Ok(None);
        };
        let request = self.conversation.begin_episode(seed(*next), SCENARIO.name());
        Ok(Some(Request::Reset(request)))
    }
}

impl Client {
    /// As DDS identifies it.
    fn identity(self) -> [u8; 16] {
        (u128::from(self.start) << 1 | u128::from(self.is_first)).to_be_bytes()
    }
}

impl PartialEq for Simulator {
    fn eq(&self, other: &Simulator) -> bool {
        (self.start, &self.executed) == (other.start, &other.executed)
    }
}

impl Eq for Simulator {}

impl Hash for Simulator {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.start, &self.executed).hash(state);
    }
}

impl Debug for Simulator {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Simulator")
            .field("start", &self.start)
            .field("executed", &self.executed)
            .finish_non_exhaustive()
    }
}

impl Eq for Letter {}

impl Hash for Letter {
    fn hash<H: Hasher>(&self, state: &mut H) {
        match &self.0 {
            Answer::Reset(response) => response.hash(state),
            Answer::Step(response) => {
                // A float cannot be hashed; the reward follows from the rest.
                let step::Response { status, message, image, reward: _, terminated, .. } = response;
                (status, message, image, terminated).hash(state);
                let step::Response { truncated, blocked, episode, step, .. } = response;
                (truncated, blocked, episode, step).hash(state);
            }
        }
    }
}

/// Without the image.
impl Debug for Letter {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match &self.0 {
            Answer::Reset(response) => {
                write!(f, "{}, episode {}", status::name(response.status), response.episode)
            }
            Answer::Step(response) => {
                let step::Response { status, episode, step, .. } = response;
                write!(f, "{}, episode {episode}, step {step}", status::name(*status))
            }
        }
    }
}

fn settings() -> WorldSettings {
    WorldSettings { max_steps: ACTIONS.len() as u32, ..WorldSettings::default() }
}

fn number(start: u32) -> NonZeroU32 {
    NonZeroU32::new(start).expect("starts count from 1")
}

fn seed(seed: u64) -> NonZeroU64 {
    NonZeroU64::new(seed).expect("0 is no seed")
}

fn action(index: u8) -> Action {
    Action::try_from(index).expect("an action")
}

#[test]
fn whatever_the_network_does_and_whoever_is_killed_a_step_is_taken_once() {
    let threads = available_parallelism().map_or(1, usize::from);
    let builder = Training::new().checker().threads(threads);
    let checker = builder.finish_when(HasDiscoveries::AnyFailures).spawn_bfs().join();
    println!("{} states, {} events deep", checker.unique_state_count(), checker.max_depth());
    checker.assert_properties();
}
