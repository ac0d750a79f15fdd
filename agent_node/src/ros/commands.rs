//! What the program does over DDS: train and evaluate; and the seeds of a test.

use std::{collections::BTreeMap, fs, num::NonZeroU64, path::Path, time::Duration};

use anyhow::Context;
use evac_msgs::TrainingStatus;
use log::{info, warn};
use ros_runtime::{
    Arguments, Clock, Node, Publisher,
    node::reliable,
    parameters::{ParameterClient, ParameterValue},
};
use task::Image;

use super::{
    console::Console,
    diagnostics::LearnerState,
    escapes,
    ground_truth::GroundTruth,
    name_in,
    parameters::{
        Defaults, TrainedModel, count, declare, model_settings, scenario, training_settings,
    },
    publishers::publish_status,
    simulator::{Connection, Simulator},
};
use crate::{
    background::Background,
    environment::EnvironmentError,
    learning::{
        dyna_q::Decision,
        evaluation::{Evaluation, TestEpisode, TestListener, TestPlan, run_test},
        policy::Policy,
        record::EpisodeRecord,
        seeds::{Purpose, episode_seed},
        training::{Listener, Plan, Training, TrainingError},
    },
    report::{CaptionedFrame, EscapeFigures, Report, RunFacts, TensorBoard},
    run::{RunDirectory, Summary},
    saver::{self, Saver},
};

/// The largest seed: parameters are signed in ROS.
const LARGEST_SEED: u64 = (1 << 53) - 1;
/// Each has a record in memory, of 48 bytes, and a row in episodes.csv, which every checkpoint writes.
const MOST_EPISODES: u64 = 1_000_000;
/// More would be more participants than a DDS domain takes on one machine.
const MOST_SIMULATORS: u64 = 64;
/// How long to wait for the simulator's parameters, which are only for the record.
const PARAMETER_DEADLINE: Duration = Duration::from_secs(10);
/// Images that the report shows.
const REPORT_FRAMES: usize = 8;

/// Prints the seeds of a test, one a line: `sim_node oracle` computes the fewest steps for them.
pub fn seeds(seed: u64, episodes: u32) -> String {
    let seeds = (0..episodes).map(|episode| episode_seed(Purpose::Test, seed, episode));
    seeds.map(|seed| format!("{seed}\n")).collect()
}

/// Trains over DDS, then tests, and leaves everything in the directory `out`.
///
/// `oracle` is a file of the fewest possible steps of the test's episodes, if there is one.
pub fn train(arguments: &Arguments, oracle: Option<&Path>) -> anyhow::Result<()> {
    let oracle = oracle.map(read_oracle).transpose()?;
    let mut node = Node::new("agent_node", arguments)?;
    let parameters = node.parameters().clone();
    let (preset, settings) = model_settings(&parameters, &Defaults::default())?;
    let settings = training_settings(&parameters, settings)?;
    let simulators = count(
        &parameters,
        "simulators",
        1,
        1..=MOST_SIMULATORS,
        "how many simulators to learn in at once; several stand in the namespaces sim0, sim1, ...",
    )? as usize;
    let plan = Plan {
        scenario: scenario(&parameters, &Defaults::default())?,
        episodes: count(
            &parameters,
            "episodes",
            preset.episodes().into(),
            1..=MOST_EPISODES,
            "training episodes",
        )? as u32,
        seed: count(&parameters, "seed", 0, 0..=LARGEST_SEED, "the run is a function of it")?,
        rooms: simulators,
    };
    let default_out = format!("runs/{}-{preset}-seed{}", plan.scenario, plan.seed);
    let out = declare(&parameters, "out", default_out, "the directory of the run's files")?;
    let resume = declare(&parameters, "resume", false, "go on from the checkpoint in out")?;
    let checkpoint_interval = count(
        &parameters,
        "checkpoint_interval",
        100,
        1..=10_000_000,
        "episodes between two checkpoints; one is also saved at the end and on Ctrl-C",
    )? as u32;
    let test = TestParameters::declare(&parameters, "evaluation_episodes", "evaluation_seed", 0)?;
    let namespaces: Vec<String> = match simulators {
        1 => vec![String::new()],
        _ => (0..simulators).map(|index| format!("sim{index}")).collect(),
    };
    let common = Common::declare(&mut node, &namespaces[0])?;
    node.start_services()?;

    let out = Path::new(&out);
    let (directory, mut training) = match resume {
        true => {
            let directory = RunDirectory::open(out)?;
            let training = saver::load(&directory, &plan, &settings)?;
            info!("going on with episode {} of {}", training.episode(), training.plan.episodes);
            (directory, training)
        }
        false => {
            let (directory, kept) = RunDirectory::create(out)?;
            if let Some(kept) = kept {
                info!("the earlier run in {} is now {}", out.display(), kept.display());
            }
            (directory, Training::new(plan, settings)?)
        }
    };
    // Under the nodes' own names, whatever they were remapped to.
    let mut config = BTreeMap::from([("agent_node".to_owned(), parameters.values())]);
    directory.write_config(&config)?;

    let statuses = node.create_publisher("training_status", reliable(10))?;
    let connections = namespaces.iter().map(|namespace| Connection::new(&mut node, namespace));
    let connections = connections.collect::<Result<Vec<_>, _>>()?;
    let mut rooms = Vec::new();
    for connection in connections {
        match connect(&node, connection, common.deadline)? {
            Some(room) => rooms.push(room),
            None => return Ok(()),
        }
    }
    let mut listener = TrainingListener {
        console: Console::new("training", training.plan.episodes, training.episode()),
        board: Some(TensorBoard::create(&directory.file("tensorboard"), training.episode())?),
        saver: Saver::start(&directory)?,
        statuses,
        clock: node.clock().clone(),
        state: LearnerState::reported_by(node.diagnostics()),
        checkpoint_interval,
        done: training.episode(),
    };
    let outcome = match rooms.as_mut_slice() {
        [room] => std::thread::scope(|scope| {
            let mut room = [Background::start(scope, room).context("no thread for the room")?];
            training.run(&mut room, &mut listener)
        }),
        // With several there is enough to do while each of them works.
        rooms => training.run(rooms, &mut listener),
    };
    drop(listener);
    let (episode, path) = (training.episode(), out.display());
    match outcome {
        Ok(()) => saver::write(&training, &directory)?,
        Err(TrainingError::Environment(EnvironmentError::Shutdown)) => {
            saver::write(&training, &directory)?;
            info!(
                "stopped in episode {episode}, saved in {path}: the same command with --resume goes on"
            );
            return Ok(());
        }
        Err(error @ (TrainingError::Environment(_) | TrainingError::Listener(_))) => {
            let saved = match saver::write(&training, &directory) {
                Ok(()) => format!("saved in {path}"),
                Err(reason) => format!("and could not be saved: {reason:#}"),
            };
            return Err(error).context(format!("stopped in episode {episode}, {saved}"));
        }
        // What cannot be computed any further is no state to go on from.
        Err(error) => {
            return Err(error).context(format!(
                "stopped in episode {episode}; the checkpoint in {path} is that of before"
            ));
        }
    }

    add_simulator_parameters(&node, &common, &mut config);
    directory.write_config(&config)?;
    let mut summary = Summary {
        scenario: training.plan.scenario.clone(),
        preset: preset.to_string(),
        seed: training.plan.seed,
        episodes: training.episode(),
        steps: training.progress.total_steps,
        wall_s: training.progress.wall.as_secs_f64(),
        steps_per_s: training.steps_per_s(),
        update_us: training.update_us(),
        evaluation: None,
    };
    directory.write_json("summary.json", &summary)?;
    let (mut frames, mut escapes) = (Vec::new(), None);
    if test.episodes > 0 {
        let plan = test.plan(&training.plan.scenario);
        let mut policy = training.policy()?;
        let room = &mut rooms[0];
        let Some(tested) = run_and_sum_up(&plan, &mut policy, room, oracle.as_ref())? else {
            info!("stopped before the end of the test; the training is complete");
            return Ok(());
        };
        summary.evaluation = Some(tested.evaluation);
        frames = tested.frames;
        directory.write_json("summary.json", &summary)?;
        escapes = draw_escapes(&plan, &mut policy, room, &namespaces[0], &common, &directory)?;
    }
    let records: Vec<_> = training.progress.records.iter().cloned().collect();
    let (records, evaluation) = (&records, summary.evaluation.as_ref());
    let (frames, escapes) = (&frames, escapes.as_ref());
    let report = Report { run: facts(&summary), records, evaluation, frames, escapes };
    if let Some(curve) = report.learning_curve()? {
        let figures = RunDirectory::open(&directory.file("figures"))?;
        figures.write("learning_curve.svg", curve.as_bytes())?;
    }
    directory.write("report.html", report.to_html()?.as_bytes())?;
    info!("everything is in {}", out.display());
    Ok(())
}

/// Tests a trained model over DDS and leaves `evaluation.json` in the directory `out`.
///
/// `oracle` is as in [`train`].
pub fn evaluate(arguments: &Arguments, oracle: Option<&Path>) -> anyhow::Result<()> {
    let oracle = oracle.map(read_oracle).transpose()?;
    let mut node = Node::new("agent_node", arguments)?;
    let parameters = node.parameters().clone();
    let model = TrainedModel::declare(&parameters)?;
    let scenario = scenario(&parameters, &model.defaults)?;
    let test = TestParameters::declare(&parameters, "episodes", "seed", 1)?;
    let default_out = model.directory.display().to_string();
    let out = declare(&parameters, "out", default_out, "the directory of evaluation.json")?;
    let common = Common::declare(&mut node, "")?;
    node.start_services()?;

    let mut policy = model.policy()?;
    let directory = RunDirectory::open(Path::new(&out))?;
    let connection = Connection::new(&mut node, "")?;
    let Some(mut room) = connect(&node, connection, common.deadline)? else {
        return Ok(());
    };
    let plan = test.plan(&scenario);
    match run_and_sum_up(&plan, &mut policy, &mut room, oracle.as_ref())? {
        Some(tested) => {
            directory.write_json("evaluation.json", &tested.evaluation)?;
            draw_escapes(&plan, &mut policy, &mut room, "", &common, &directory)?;
        }
        None => info!("stopped before the end of the test"),
    }
    Ok(())
}

/// Draws the policy's escapes into the directory `figures`; `None` where they cannot be seen, or if the
/// node shuts down.
fn draw_escapes(
    plan: &TestPlan,
    policy: &mut Policy,
    room: &mut Simulator,
    namespace: &str,
    common: &Common,
    directory: &RunDirectory,
) -> anyhow::Result<Option<EscapeFigures>> {
    if !common.figures {
        return Ok(None);
    }
    let truth = GroundTruth::new(room.node(), namespace)?;
    let figures = match escapes::figures(plan, policy, room, &truth, &common.simulator_parameters) {
        Ok(Some(figures)) => figures,
        Ok(None) => return Ok(None),
        // What is done is done; only pictures are missing.
        Err(error) => {
            warn!("there are no figures of escapes: {error:#}");
            return Ok(None);
        }
    };
    let directory = RunDirectory::open(&directory.file("figures"))?;
    figures.files().try_for_each(|(name, bytes)| directory.write(&name, bytes))?;
    Ok(Some(figures))
}

/// What `train` and `evaluate` have in common.
struct Common {
    deadline: Option<Duration>,
    simulator_parameters: ParameterClient,
    simulator: String,
    figures: bool,
}

impl Common {
    /// `namespace` is that of the simulator whose parameters are recorded.
    fn declare(node: &mut Node, namespace: &str) -> anyhow::Result<Common> {
        let parameters = node.parameters().clone();
        let deadline = parameters.declare(
            "simulator_timeout",
            120.0,
            ros_runtime::parameters::Descriptor::read_only(
                "how long the simulator may be silent, in seconds, before the agent gives up; 0: for ever",
            )
            .range(0.0..=1e6),
        )?;
        let default = name_in(namespace, "sim_node");
        let simulator = declare(&parameters, "simulator", default, "the simulator's node")?;
        let figures = declare(&parameters, "figures", true, "draw some escapes after the test")?;
        parameters.refuse_undeclared()?;
        Ok(Common {
            deadline: (deadline > 0.0).then(|| Duration::from_secs_f64(deadline)),
            simulator_parameters: ParameterClient::new(node, &simulator)?,
            simulator,
            figures,
        })
    }
}

/// How long a test is, and of what.
struct TestParameters {
    episodes: u32,
    seed: u64,
    max_steps: u32,
}

impl TestParameters {
    fn declare(
        parameters: &ros_runtime::parameters::Parameters,
        episodes: &str,
        seed: &str,
        least: u64,
    ) -> anyhow::Result<TestParameters> {
        let episodes_are = "greedy test episodes";
        // Every model is tested in the same rooms, unless somebody says otherwise.
        let seed_is = "the seed of the test; its episodes are never those of a training";
        let steps_are = "steps after which a test episode counts as a failure";
        Ok(TestParameters {
            episodes: count(parameters, episodes, 1000, least..=10_000_000, episodes_are)? as u32,
            seed: count(parameters, seed, 1, 0..=LARGEST_SEED, seed_is)?,
            max_steps: count(parameters, "max_steps", 200, 1..=1_000_000, steps_are)? as u32,
        })
    }

    fn plan(&self, scenario: &str) -> TestPlan {
        let TestParameters { episodes, seed, max_steps } = *self;
        TestPlan { scenario: scenario.to_owned(), episodes, seed, max_steps }
    }
}

/// `sim_node oracle`'s output.
#[derive(serde::Deserialize)]
struct Oracle {
    scenario: String,
    seeds: Vec<NonZeroU64>,
    steps: Vec<Option<u32>>,
}

impl Oracle {
    /// Whether it is of the very episodes of a test.
    fn is_of(&self, plan: &TestPlan) -> bool {
        let seeds = (0..plan.episodes).map(|e| episode_seed(Purpose::Test, plan.seed, e));
        self.scenario == plan.scenario && self.seeds.iter().copied().eq(seeds)
    }
}

fn read_oracle(path: &Path) -> anyhow::Result<Oracle> {
    let context = || format!("--oracle {}", path.display());
    let text = fs::read_to_string(path).with_context(context)?;
    serde_json::from_str(&text).with_context(context)
}

/// The simulator, or `None` if the node shut down before there was one.
fn connect(
    node: &Node,
    connection: Connection,
    deadline: Option<Duration>,
) -> anyhow::Result<Option<Simulator<'_>>> {
    match Simulator::connect(node, connection, deadline) {
        Ok(simulator) => Ok(Some(simulator)),
        Err(EnvironmentError::Shutdown) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// What a test leaves.
struct Tested {
    evaluation: Evaluation,
    frames: Vec<CaptionedFrame>,
}

/// Runs a test; `None` if the node shut down before its end.
fn run_and_sum_up(
    plan: &TestPlan,
    policy: &mut Policy,
    room: &mut Simulator,
    oracle: Option<&Oracle>,
) -> anyhow::Result<Option<Tested>> {
    let mut listener = ConsoleTestListener {
        console: Console::new("test", plan.episodes, 0),
        episodes: plan.episodes,
        escaped: 0,
        frames: Vec::new(),
    };
    let episodes = match run_test(plan, policy, room, &mut listener) {
        Ok(episodes) => episodes,
        Err(TrainingError::Environment(EnvironmentError::Shutdown)) => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    let fitting = oracle.filter(|oracle| oracle.is_of(plan));
    if oracle.is_some() && fitting.is_none() {
        warn!("--oracle is of another scenario or of other seeds than the test: it is left out");
    }
    let evaluation =
        Evaluation::new(plan, &episodes, fitting.map(|oracle| oracle.steps.as_slice()));
    let (successes, rate) = (evaluation.successes, 100.0 * evaluation.success_rate);
    info!("{successes} of {} test episodes escaped: {rate:.1} %", evaluation.episodes);
    Ok(Some(Tested { evaluation, frames: listener.frames }))
}

struct ConsoleTestListener {
    console: Console,
    episodes: u32,
    escaped: u32,
    frames: Vec<CaptionedFrame>,
}

impl TestListener for ConsoleTestListener {
    fn step(&mut self, episode: u32, step: u32, image: &Image, decision: &Decision) {
        // The first image of some episodes, and where the robot goes from there.
        if step == 0 && self.frames.len() < REPORT_FRAMES {
            let turn = decision.action.turn_degrees();
            let caption = format!("Test episode {episode}: the policy turns {turn:+}\u{b0}");
            self.frames.push(CaptionedFrame { image: image.clone(), caption });
        }
    }

    fn episode(&mut self, result: &TestEpisode) {
        self.escaped += u32::from(result.escaped);
        self.console.test_episode(result.episode + 1, self.episodes, self.escaped, result);
    }
}

struct TrainingListener {
    console: Console,
    /// None once it cannot be written.
    board: Option<TensorBoard>,
    saver: Saver,
    statuses: Publisher<TrainingStatus>,
    clock: Clock,
    state: LearnerState,
    checkpoint_interval: u32,
    /// Episodes that were told of.
    done: u32,
}

impl Listener for TrainingListener {
    fn episode(&mut self, training: &Training, record: &EpisodeRecord) -> anyhow::Result<()> {
        if let Some(board) = &mut self.board
            && let Err(error) = board.record(record, training.progress.total_steps)
        {
            warn!("{:#}: the training goes on without", anyhow::Error::from(error));
            self.board = None;
        }
        publish_status(&self.statuses, &self.clock, training, record);
        self.state.update(training);
        self.console.training_episode(training);
        self.done += 1;
        let done = self.done;
        if done.is_multiple_of(self.checkpoint_interval) && done < training.plan.episodes {
            self.saver.save(training)?;
        }
        Ok(())
    }
}

/// The simulator's parameters belong to the record of a run; a robot may have none.
fn add_simulator_parameters(
    node: &Node,
    common: &Common,
    config: &mut BTreeMap<String, BTreeMap<String, ParameterValue>>,
) {
    match node.block_on(common.simulator_parameters.values(PARAMETER_DEADLINE)) {
        Ok(values) => drop(config.insert("sim_node".to_owned(), values)),
        Err(error) => warn!("config.yaml lacks the parameters of {}: {error}", common.simulator),
    }
}

fn facts(summary: &Summary) -> RunFacts<'_> {
    RunFacts {
        scenario: &summary.scenario,
        preset: &summary.preset,
        seed: summary.seed,
        episodes: summary.episodes,
        steps: summary.steps,
        wall_s: summary.wall_s,
        steps_per_s: summary.steps_per_s,
        update_us: (summary.update_us > 0.0).then_some(summary.update_us),
    }
}
