//! `agent_node train`.

use std::{collections::BTreeMap, path::Path};

use anyhow::Context;
use learning::{
    run::{RunDirectory, Summary},
    saver::{self, Saver},
    settings::{Preset, Settings},
    training::{Plan, Training, TrainingError},
};
use log::info;
use report::{CaptionedFrame, EscapeFigures, Report, RunFacts, TensorBoard};
use ros_runtime::{Arguments, Node, node::reliable, parameters::Parameters};
use task::FewestSteps;

use super::{
    common::{Common, CommonParameters, LARGEST_SEED, TestParameters},
    console::Console,
    diagnostics::LearnerState,
    escapes,
    parameters::{Defaults, count, declare, model_settings, scenario, training_settings},
    policy_test::{PolicyTest, read_fewest_steps},
    simulator::{Connection, Simulator},
    simulator_error::SimulatorError,
    training_listener::TrainingListener,
};
use crate::background::Background;

/// Each has a record in memory, of 48 bytes, and a row in episodes.csv, which every checkpoint writes.
const MOST_EPISODES: u64 = 1_000_000;
/// More would be more participants than a DDS domain takes on one machine.
const MOST_SIMULATORS: u64 = 64;

/// Trains over DDS, then tests, and leaves everything in the directory `out`.
///
/// `oracle` is a file of the fewest possible steps of the test's episodes, if there is one.
///
/// # Errors
///
/// Arguments, parameters or files are wrong, a simulator cannot be used, or the training diverges.
/// What has been learned is saved all the same.
pub fn train(arguments: &Arguments, oracle: Option<&Path>) -> anyhow::Result<()> {
    let fewest = oracle.map(read_fewest_steps).transpose()?;
    let mut node = Node::new("agent_node", arguments, evac_msgs::DEFINITIONS)?;
    let options = Options::declare(node.parameters())?;
    let namespaces = options.namespaces();
    let common = CommonParameters::declare(node.parameters(), &namespaces[0])?;
    let common = Common::new(&mut node, common)?;
    node.start_services()?;

    let preset = options.preset;
    let (directory, mut training) = options.begin()?;
    // Under the nodes' default names, also if they are remapped.
    let mut config = BTreeMap::from([("agent_node".to_owned(), node.parameters().values())]);
    directory.write_config(&config)?;

    let mut listener = options.listener(&mut node, &directory, &training)?;
    let connections = namespaces.iter().map(|namespace| Connection::new(&mut node, namespace));
    let connections = connections.collect::<Result<Vec<_>, _>>()?;
    let (connections, announcers): (Vec<_>, Vec<_>) = connections.into_iter().unzip();
    listener.announcers = announcers;
    node.tell_ready();
    let mut rooms = Vec::new();
    for connection in connections {
        match common.connect(&node, connection)? {
            Some(room) => rooms.push(room),
            None => return Ok(()),
        }
    }
    let outcome = run(&mut training, &mut rooms, &mut listener);
    let TrainingListener { announcers, .. } = listener;
    if !save(outcome, &training, &directory, &options.out)? {
        return Ok(());
    }

    common.record_simulator(&node, &mut config);
    directory.write_config(&config)?;
    let mut summary = summary(&training, preset);
    directory.write_json("summary.json", &summary)?;
    let mut pictures = Pictures::default();
    if options.test.episodes > 0 {
        let test = PolicyTest {
            plan: options.test.plan(&training.plan.scenario),
            policy: training.policy()?,
            room: &mut rooms[0],
            announcer: &announcers[0],
        };
        let show = (namespaces[0].as_str(), &common, &directory);
        let Some(tested) = test_and_draw(test, fewest.as_ref(), show, &mut summary)? else {
            info!("stopped before the end of the test; the training is complete");
            return Ok(());
        };
        pictures = tested;
    }
    write_report(&training, &summary, &pictures, &directory)?;
    info!("everything is in {}", options.out);
    Ok(())
}

/// Declares what [`train`] declares.
pub(super) fn declare_parameters(parameters: &Parameters) -> anyhow::Result<()> {
    let options = Options::declare(parameters)?;
    CommonParameters::declare(parameters, &options.namespaces()[0])?;
    Ok(())
}

/// The parameters of a training.
struct Options {
    preset: Preset,
    settings: Settings,
    plan: Plan,
    out: String,
    resume: bool,
    checkpoint_interval: u32,
    test: TestParameters,
}

impl Options {
    fn declare(parameters: &Parameters) -> anyhow::Result<Options> {
        let (preset, settings) = model_settings(parameters, &Defaults::default())?;
        let settings = training_settings(parameters, settings)?;
        let simulators = count(
            parameters,
            "simulators",
            1,
            1..=MOST_SIMULATORS,
            "how many simulators to learn in at once; several stand in the namespaces sim0, sim1, ...",
        )? as usize;
        let plan = Plan {
            scenario: scenario(parameters, &Defaults::default())?,
            episodes: count(
                parameters,
                "episodes",
                preset.episodes().into(),
                1..=MOST_EPISODES,
                "training episodes",
            )? as u32,
            seed: count(parameters, "seed", 0, 0..=LARGEST_SEED, "the run is a function of it")?,
            rooms: simulators,
        };
        let default_out = format!("runs/{}-{preset}-seed{}", plan.scenario, plan.seed);
        let out = declare(parameters, "out", default_out, "the directory of the run's files")?;
        let resume = declare(parameters, "resume", false, "go on from the checkpoint in out")?;
        let checkpoint_interval = count(
            parameters,
            "checkpoint_interval",
            100,
            1..=10_000_000,
            "episodes between two checkpoints; one is also saved at the end and on Ctrl-C",
        )? as u32;
        let test =
            TestParameters::declare(parameters, "evaluation_episodes", "evaluation_seed", 0)?;
        Ok(Options { preset, settings, plan, out, resume, checkpoint_interval, test })
    }

    /// Where the simulators stand, relative to the node.
    fn namespaces(&self) -> Vec<String> {
        match self.plan.rooms {
            1 => vec![String::new()],
            rooms => (0..rooms).map(|index| format!("sim{index}")).collect(),
        }
    }

    /// The directory of the run, and the training: a new one, or that of the last checkpoint.
    fn begin(&self) -> anyhow::Result<(RunDirectory, Training)> {
        let out = Path::new(&self.out);
        if self.resume {
            let directory = RunDirectory::open(out)?;
            let training = saver::load(&directory, &self.plan, &self.settings)?;
            info!("going on with episode {} of {}", training.episode(), training.plan.episodes);
            return Ok((directory, training));
        }
        let (directory, kept) = RunDirectory::create(out)?;
        if let Some(kept) = kept {
            info!("the earlier run in {} is now {}", out.display(), kept.display());
        }
        Ok((directory, Training::new(self.plan.clone(), self.settings.clone())?))
    }

    fn listener(
        &self,
        node: &mut Node,
        directory: &RunDirectory,
        training: &Training,
    ) -> anyhow::Result<TrainingListener> {
        Ok(TrainingListener {
            console: Console::new("training", training.plan.episodes, training.episode()),
            announcers: Vec::new(),
            board: Some(TensorBoard::create(&directory.file("tensorboard"), training.episode())?),
            saver: Saver::start(directory)?,
            statuses: node.create_publisher("training_status", reliable(10))?,
            clock: node.clock().clone(),
            state: LearnerState::reported_by(node.diagnostics()),
            checkpoint_interval: self.checkpoint_interval,
            done: training.episode(),
        })
    }
}

/// Learns in these rooms, the only one of them on a thread of its own.
fn run(
    training: &mut Training,
    rooms: &mut [Simulator],
    listener: &mut TrainingListener,
) -> Result<(), TrainingError<SimulatorError>> {
    match rooms {
        [room] => std::thread::scope(|scope| {
            let room = Background::start(scope, room).context("no thread for the room")?;
            training.run(&mut [room], listener)
        }),
        // With several there is enough to do while each of them works.
        rooms => training.run(rooms, listener),
    }
}

/// Saves the training, also after an error. Returns whether it is complete.
fn save(
    outcome: Result<(), TrainingError<SimulatorError>>,
    training: &Training,
    directory: &RunDirectory,
    out: &str,
) -> anyhow::Result<bool> {
    let episode = training.episode();
    match outcome {
        Ok(()) => {
            saver::write(training, directory)?;
            Ok(true)
        }
        Err(TrainingError::Environment(SimulatorError::Shutdown)) => {
            saver::write(training, directory)?;
            info!(
                "stopped in episode {episode}, saved in {out}: the same command with --resume goes on"
            );
            Ok(false)
        }
        // What cannot be computed any further is no state to go on from.
        Err(error @ TrainingError::Diverged { .. }) => Err(error).context(format!(
            "stopped in episode {episode}; the checkpoint in {out} is that of before"
        )),
        Err(error) => {
            let saved = match saver::write(training, directory) {
                Ok(()) => format!("saved in {out}"),
                Err(reason) => format!("and could not be saved: {reason:#}"),
            };
            Err(error).context(format!("stopped in episode {episode}, {saved}"))
        }
    }
}

fn summary(training: &Training, preset: Preset) -> Summary {
    Summary {
        scenario: training.plan.scenario.clone(),
        preset: preset.to_string(),
        seed: training.plan.seed,
        episodes: training.episode(),
        steps: training.progress.total_steps,
        wall_s: training.progress.wall.as_secs_f64(),
        steps_per_s: training.steps_per_s(),
        update_us: training.update_us(),
        evaluation: None,
    }
}

/// What a test shows in the report.
#[derive(Default)]
struct Pictures {
    frames: Vec<CaptionedFrame>,
    escapes: Option<EscapeFigures>,
}

/// Tests the policy and writes what comes of it; `None` if the node shut down before its end. What it
/// shows is that of a simulator's namespace.
fn test_and_draw(
    mut test: PolicyTest,
    fewest: Option<&FewestSteps>,
    (namespace, common, directory): (&str, &Common, &RunDirectory),
    summary: &mut Summary,
) -> anyhow::Result<Option<Pictures>> {
    let Some(tested) = test.run(fewest)? else {
        return Ok(None);
    };
    summary.evaluation = Some(tested.evaluation);
    directory.write_json("summary.json", &summary)?;
    let escapes = escapes::draw(&mut test, namespace, common, directory)?;
    Ok(Some(Pictures { frames: tested.frames, escapes }))
}

fn write_report(
    training: &Training,
    summary: &Summary,
    pictures: &Pictures,
    directory: &RunDirectory,
) -> anyhow::Result<()> {
    let records: Vec<_> = training.progress.records.iter().cloned().collect();
    let report = Report {
        run: facts(summary),
        records: &records,
        evaluation: summary.evaluation.as_ref(),
        frames: &pictures.frames,
        escapes: pictures.escapes.as_ref(),
    };
    if let Some(curve) = report.learning_curve()? {
        let figures = RunDirectory::open(&directory.file("figures"))?;
        figures.write("learning_curve.svg", curve.as_bytes())?;
    }
    Ok(directory.write("report.html", report.to_html()?.as_bytes())?)
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
