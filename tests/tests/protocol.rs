//! Model checking of the protocol of `/reset` and `/step`: explores every order of events and
//! checks that each step is executed exactly once.
//!
//! Both ends are the real implementations: the simulator's `Session` and the agent's
//! `Conversation`. The network between them keeps every message: each request sent so far can reach
//! the simulator at any time, any number of times or never, and so can each response to the agent's
//! pending request. This covers unlimited loss, duplication, delay, reordering and retries.
//! (Responses to other requests need not be modelled: a client discards them by the identity of
//! the request.)
//!
//! At any time, either node can be killed and restarted, the agent from a checkpoint in any of its
//! episodes, and the agent can retry with a new client, as it does when a send window is full. The
//! training is limited to two episodes of three steps, and kills and client replacements to two in
//! total. The model has about 137,000 states.
//!
//! The `always` properties must hold in every reachable state. The last of them is that the
//! training ends with the undisturbed result once messages are delivered again.

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
    Simulation,
    camera::{Camera, CameraSettings},
    ros::Session,
    world::{World, WorldSettings},
};
use stateright::{Checker, HasDiscoveries, Model, Property};
use task::{Action, Environment, Image, Scenario, Step};

/// Obstacles move in this scenario, so that no two images are equal, even if a move is blocked.
const SCENARIO: Scenario = Scenario::ThreeMoving;
/// The seed of each episode.
const SEEDS: [u64; 2] = [1, 2];
/// The actions of each episode. They are equal, so that steps differ only in their numbers. There
/// are three, so that one is still to come when the first is no longer the latest.
const ACTIONS: [u8; 3] = [3, 3, 3];
/// Maximum number of kills and client replacements.
const MAX_FAULTS: u32 = 2;

/// Upper bound on the requests in a training run, including those repeated after a restart.
const MAX_REQUESTS: usize = 100;

/// The model: a training run of a few steps.
struct Training {
    /// The results of an undisturbed training run, for each episode: the reset and each step.
    undisturbed: Vec<Vec<Outcome>>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Request {
    Reset(reset::Request),
    Step(step::Request),
}

#[derive(Clone, Debug, PartialEq)]
enum Response {
    Reset(reset::Response),
    Step(step::Response),
}

/// The result of a completed reset or step, as the learner receives it.
#[derive(Clone, Debug, PartialEq)]
enum Outcome {
    Reset(Image),
    Step(Step),
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct State {
    simulator: Simulator,
    agent: Agent,
    /// All requests sent so far.
    requests: Vec<(Client, Request)>,
    /// All responses to the agent's pending request.
    responses: Vec<Message>,
    /// Number of kills and client replacements so far.
    faults: u32,
}

/// One run of the simulator's process.
#[derive(Clone)]
struct Simulator {
    /// Number of the run, counted from 1.
    start: u32,
    /// The executed requests, which determine the session.
    executed: Vec<(Client, Request)>,
    session: Arc<Session>,
}

/// One run of the agent's process.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Agent {
    client: Client,
    conversation: Conversation,
    /// Index of the episode.
    episode: usize,
    /// Number of completed requests (the reset and steps) of the episode.
    completed: usize,
    /// Whether an outcome differed from that of an undisturbed training run.
    is_corrupted: bool,
    activity: Activity,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Activity {
    /// Waiting for the response to a request.
    Waiting(Request),
    /// The training is complete.
    Finished,
    /// Stopped, because another client has reset the simulator.
    TakenOver,
    /// Stopped by another error.
    Failed(String),
}

/// A DDS client of the agent: the first client in a run of the agent, or its replacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Client {
    start: u32,
    is_first: bool,
}

/// A response on its way to the agent.
#[derive(Clone, PartialEq)]
struct Message(Response);

#[derive(Clone, Debug, PartialEq)]
enum Event {
    /// A request reaches the simulator, possibly as a duplicate.
    Request(Client, Request),
    /// A response reaches the agent.
    Response(Message),
    /// The agent retries its request with a new client.
    NewClient,
    /// The simulator is killed and restarted.
    RestartedSimulator,
    /// The agent is killed and restarted from a checkpoint in this episode.
    RestartedAgent(usize),
}

impl Training {
    fn new() -> Training {
        let mut room = Room::new(settings());
        let mut episode = |seed| {
            let first = room.reset(seed, SCENARIO.name()).map(Outcome::Reset);
            let steps = ACTIONS.map(|index| room.step(action(index)));
            let steps = steps.into_iter().map(|step| step.map(Outcome::Step));
            [first].into_iter().chain(steps).collect::<Result<Vec<Outcome>, _>>()
        };
        let episodes: Result<Vec<_>, _> = SEEDS.map(seed).into_iter().map(&mut episode).collect();
        let undisturbed = episodes.expect("two episodes");
        let outcomes: Vec<&Outcome> = undisturbed.iter().flatten().collect();
        for (index, outcome) in outcomes.iter().enumerate() {
            // Otherwise `is_corrupted` could miss a response to the wrong request.
            assert!(!outcomes[..index].contains(outcome), "two outcomes are equal");
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
            responses: Vec::new(),
            faults: 0,
        };
        state.send_request();
        vec![state]
    }

    fn actions(&self, state: &State, events: &mut Vec<Event>) {
        let requests = state.requests.iter().cloned();
        events.extend(requests.map(|(client, request)| Event::Request(client, request)));
        events.extend(state.responses.iter().cloned().map(Event::Response));
        if state.faults == MAX_FAULTS {
            return;
        }
        let started_episodes = SEEDS.len().min(state.agent.episode + 1);
        events.extend((0..started_episodes).map(Event::RestartedAgent));
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
                let response = Message(state.simulator.handle(client, &request));
                if state.is_pending(client, &request) && !state.responses.contains(&response) {
                    state.responses.push(response);
                }
            }
            Event::Response(Message(response)) => {
                state.agent.receive(response, self);
                state.send_request();
            }
            Event::NewClient => {
                state.agent.client.is_first = false;
                state.send_request();
            }
            Event::RestartedSimulator => {
                state.simulator = Simulator::start(state.simulator.start + 1);
            }
            Event::RestartedAgent(episode) => {
                state.agent = Agent::start(state.agent.client.start + 1, episode);
                state.send_request();
            }
        }
        (state != *before).then_some(state)
    }

    fn properties(&self) -> Vec<Property<Training>> {
        vec![
            Property::<Self>::always("each request is executed once and in order", |_, state| {
                state.simulator.executes_once_and_in_order()
            }),
            Property::<Self>::always(
                "agent and simulator agree on the step, or the step is refused",
                |_, state| state.agrees_or_refuses(),
            ),
            Property::<Self>::always("the agent receives the undisturbed outcomes", |_, state| {
                !state.agent.is_corrupted
            }),
            Property::<Self>::always("only a killed agent's request stops an agent", |_, state| {
                match state.agent.activity {
                    Activity::Failed(_) => false,
                    Activity::TakenOver => state.agent.client.start > 1,
                    Activity::Waiting(_) | Activity::Finished => true,
                }
            }),
            Property::<Self>::always(
                "the training ends once messages are delivered",
                |training, state| state.ends_undisturbed(training),
            ),
            // The next two show that faults occur, so that those above are not trivially true.
            Property::<Self>::sometimes("training ends after both nodes are killed", |_, state| {
                let both = state.simulator.start > 1 && state.agent.client.start > 1;
                both && state.agent.activity == Activity::Finished
            }),
            Property::<Self>::sometimes(
                "a killed agent's reset stops its successor",
                |_, state| state.agent.activity == Activity::TakenOver,
            ),
        ]
    }
}

impl Event {
    fn is_fault(&self) -> bool {
        match self {
            Event::Request(..) | Event::Response(_) => false,
            Event::NewClient | Event::RestartedSimulator | Event::RestartedAgent(_) => true,
        }
    }
}

impl State {
    /// Sends the agent's pending request and drops the responses to its previous one.
    fn send_request(&mut self) {
        if let Activity::Waiting(request) = &self.agent.activity {
            self.requests.push((self.agent.client, request.clone()));
        }
        self.responses.clear();
    }

    /// Returns whether the agent is waiting for the response to this request.
    fn is_pending(&self, client: Client, request: &Request) -> bool {
        client.start == self.agent.client.start
            && matches!(&self.agent.activity, Activity::Waiting(pending) if pending == request)
    }

    /// Returns whether the agent's pending step, if there is one, is the simulator's latest or next
    /// step and is answered as such, or is refused with an empty image.
    fn agrees_or_refuses(&self) -> bool {
        let Activity::Waiting(Request::Step(request)) = &self.agent.activity else {
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

    /// Returns whether the training ends with the undisturbed outcomes if from now on every request
    /// is answered at once. An agent that was taken over is restarted once.
    fn ends_undisturbed(&self, training: &Training) -> bool {
        let State { mut simulator, mut agent, .. } = self.clone();
        for _ in 0..MAX_REQUESTS {
            match agent.activity.clone() {
                Activity::Waiting(request) => {
                    agent.receive(simulator.handle(agent.client, &request), training);
                }
                Activity::TakenOver if agent.client.start == self.agent.client.start => {
                    agent = Agent::start(agent.client.start + 1, agent.episode);
                }
                Activity::Finished => return !agent.is_corrupted,
                Activity::TakenOver | Activity::Failed(_) => return false,
            }
        }
        false
    }
}

impl Simulator {
    fn start(start: u32) -> Simulator {
        let world = World::new(settings(), SCENARIO, 0).expect("a possible layout");
        let camera = Camera::new(CameraSettings::default()).expect("valid default settings");
        let (session, _) = Session::numbered(number(start), Simulation::new(world, camera), 0.5);
        Simulator { start, executed: Vec::new(), session: Arc::new(session) }
    }

    fn handle(&mut self, client: Client, request: &Request) -> Response {
        let session = Arc::make_mut(&mut self.session);
        let (response, executed) = match request {
            Request::Reset(request) => {
                let (response, executed) = session.reset(client.identity(), request, SCENARIO);
                (Response::Reset(response), executed)
            }
            Request::Step(request) => {
                let (response, executed) = session.step(request);
                (Response::Step(response), executed)
            }
        };
        if executed.is_some() {
            self.executed.push((client, request.clone()));
        }
        response
    }

    fn executes_once_and_in_order(&self) -> bool {
        // Episode 1 begins with the simulator's own reset at startup.
        let (mut episode, mut steps) = (u64::from(self.start) << 32 | 1, 0);
        self.executed.iter().enumerate().all(|(index, (_, request))| match request {
            Request::Reset(_) => {
                (episode, steps) = (episode + 1, 0);
                self.executed[..index].iter().all(|(_, earlier)| earlier != request)
            }
            Request::Step(step) => {
                steps += 1;
                (step.episode, step.step) == (episode, steps)
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
            completed: 0,
            is_corrupted: false,
            activity: Activity::Waiting(request),
        }
    }

    fn is_resetting(&self) -> bool {
        matches!(self.activity, Activity::Waiting(Request::Reset(_)))
    }

    fn receive(&mut self, response: Response, training: &Training) {
        self.activity = match self.next_request(response, training) {
            Ok(Some(request)) => Activity::Waiting(request),
            Ok(None) => Activity::Finished,
            Err(SimulatorError::TakenOver(_)) => Activity::TakenOver,
            Err(error) => Activity::Failed(error.to_string()),
        };
    }

    /// Returns the request that follows a response; `None` at the end of the training.
    fn next_request(
        &mut self,
        response: Response,
        training: &Training,
    ) -> Result<Option<Request>, SimulatorError> {
        let outcome = match response {
            Response::Reset(response) if self.completed == 0 => {
                Outcome::Reset(self.conversation.begun(response)?)
            }
            Response::Reset(response) => {
                return Ok(Some(Request::Step(self.conversation.repeated(response)?)));
            }
            Response::Step(response) => match self.conversation.stepped(response)? {
                AfterStep::Done(step) => Outcome::Step(step),
                AfterStep::Step(request) => return Ok(Some(Request::Step(request))),
                AfterStep::Reset(request) => return Ok(Some(Request::Reset(request))),
            },
        };
        self.is_corrupted |= outcome != training.undisturbed[self.episode][self.completed];
        self.completed += 1;
        if let Some(index) = ACTIONS.get(self.completed - 1) {
            return Ok(Some(Request::Step(self.conversation.begin_step(action(*index))?)));
        }
        (self.episode, self.completed) = (self.episode + 1, 0);
        let Some(next) = SEEDS.get(self.episode) else {
            return Ok(None);
        };
        let request = self.conversation.begin_episode(seed(*next), SCENARIO.name());
        Ok(Some(Request::Reset(request)))
    }
}

impl Client {
    /// Returns a unique identity in place of the client's GUID.
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

impl Eq for Message {}

impl Hash for Message {
    fn hash<H: Hasher>(&self, state: &mut H) {
        match &self.0 {
            Response::Reset(response) => response.hash(state),
            Response::Step(response) => {
                // Floats are not hashable; the other fields determine the reward.
                let step::Response { status, message, image, reward: _, terminated, .. } = response;
                (status, message, image, terminated).hash(state);
                let step::Response { truncated, blocked, episode, step, .. } = response;
                (truncated, blocked, episode, step).hash(state);
            }
        }
    }
}

/// Omits the image.
impl Debug for Message {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match &self.0 {
            Response::Reset(response) => {
                write!(f, "{}, episode {}", status::name(response.status), response.episode)
            }
            Response::Step(response) => {
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
    NonZeroU32::new(start).expect("starts are counted from 1")
}

fn seed(seed: u64) -> NonZeroU64 {
    NonZeroU64::new(seed).expect("seeds are not 0")
}

fn action(index: u8) -> Action {
    Action::try_from(index).expect("an action")
}

#[test]
fn each_step_is_executed_once_despite_network_faults_and_kills() {
    let threads = available_parallelism().map_or(1, usize::from);
    let builder = Training::new().checker().threads(threads);
    let checker = builder.finish_when(HasDiscoveries::AnyFailures).spawn_bfs().join();
    println!("{} states, depth {}", checker.unique_state_count(), checker.max_depth());
    checker.assert_properties();
}
