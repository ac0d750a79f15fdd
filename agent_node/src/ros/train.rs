//! `agent_node train`: trains over DDS, then evaluates the policy.

use std::{collections::BTreeMap, path::Path};

use anyhow::Context;
use learning::{
    run::{RunDirectory, Summary},
    saver::{self, Saver},
    settings::{Preset, Settings},
    training::{Plan, Training, TrainingError},
};
use log::info;
use report::{CaptionedFrame, EscapeFigures, Report, RunSummary, TensorBoard};
use ros_runtime::{Arguments, Node, node::reliable, parameters::Parameters};
use task::ShortestPaths;

use super::{
    common::{Common, CommonParameters, EvaluationParameters, LARGEST_SEED},
    console::Console,
    diagnostics::LearnerState,
    escapes,
    parameters::{Defaults, count, declare, model_settings, scenario, training_settings},
    policy_evaluation::{PolicyEvaluation, read_shortest_paths},
    simulator::{Connection, Simulator},
    simulator_error::SimulatorError,
    training_listener::TrainingListener,
};
use crate::background::Background;

/// The maximum of the parameter `episodes`. Each episode takes 48 bytes of memory and a row in
/// episodes.csv, which is rewritten with every checkpoint.
const MAX_EPISODES: u64 = 1_000_000;
/// The maximum of the parameter `simulators`. Each simulator is a DDS participant, and the port
/// numbers of a domain allow 120 participants on one machine.
const MAX_SIMULATORS: u64 = 64;

/// Trains over DDS, then evaluates the policy. Writes all files of the run to the directory given
/// by the parameter `out`.
///
/// `oracle` is a file with the output of `sim_node oracle` for the evaluation episodes: the lengths
/// of the full-knowledge shortest paths, which are the baseline for `optimality_ratio`.
///
/// # Errors
///
/// Returns an error if arguments, parameters or files are invalid, if a file cannot be written, if
/// an environment fails, or if training diverges. Progress up to the error is saved unless training
/// diverged; in that case, the last checkpoint is kept.
pub fn train(arguments: &Arguments, oracle: Option<&Path>) -> anyhow::Result<()> {
    let shortest = oracle.map(read_shortest_paths).transpose()?;
    let mut node = Node::new("agent_node", arguments, evac_msgs::DEFINITIONS)?;
    let options = Options::declare(node.parameters())?;
    let namespaces = options.namespaces();
    let common = CommonParameters::declare(node.parameters(), &namespaces[0])?;
    let common = Common::new(&mut node, common)?;
    node.start_services()?;

    let preset = options.preset;
    let (directory, mut training) = options.begin()?;
    // The default node names are used even if the nodes are remapped, because `Defaults::of_model`
    // and `--params-file` look up the parameters by these names.
    let mut config = BTreeMap::from([("agent_node".to_owned(), node.parameters().values())]);
    directory.write_config(&config)?;

    let mut listener = options.listener(&mut node, &directory, &training)?;
    let connections = namespaces.iter().map(|namespace| Connection::new(&mut node, namespace));
    let connections = connections.collect::<Result<Vec<_>, _>>()?;
    let (connections, announcers): (Vec<_>, Vec<_>) = connections.into_iter().unzip();
    listener.announcers = announcers;
    node.notify_ready();
    let mut environments = Vec::new();
    for connection in connections {
        match common.connect(&node, connection)? {
            Some(environment) => environments.push(environment),
            None => return Ok(()),
        }
    }
    let outcome = run(&mut training, &mut environments, &mut listener);
    let TrainingListener { announcers, saver, console, .. } = listener;
    // Ends the progress bar before the next one starts.
    drop(console);
    // Waits until the checkpoint that is being written is complete: `save` writes the same files.
    drop(saver);
    if !save(outcome, &training, &directory, &options.out)? {
        return Ok(());
    }

    common.record_simulator(&node, &mut config);
    directory.write_config(&config)?;
    let mut summary = summary(&training, preset);
    directory.write_json("summary.json", &summary)?;
    let mut images = EvaluationImages::default();
    if options.evaluation.episodes > 0 {
        let evaluation = PolicyEvaluation {
            plan: options.evaluation.plan(&training.plan.scenario),
            policy: training.policy(),
            environment: &mut environments[0],
            announcer: &announcers[0],
        };
        let (shortest, namespace) = (shortest.as_ref(), &namespaces[0]);
        let drawn =
            evaluate_and_draw(evaluation, shortest, namespace, &common, &directory, &mut summary)?;
        let Some(drawn) = drawn else {
            info!("evaluation interrupted; training is complete and saved");
            return Ok(());
        };
        images = drawn;
    }
    write_report(&training, &summary, &images, &directory)?;
    info!("results written to {}", options.out);
    Ok(())
}

/// Declares the parameters of [`train`].
pub(super) fn declare_parameters(parameters: &Parameters) -> anyhow::Result<()> {
    let options = Options::declare(parameters)?;
    CommonParameters::declare(parameters, &options.namespaces()[0])?;
    Ok(())
}

/// The parameters of `train`.
struct Options {
    preset: Preset,
    settings: Settings,
    plan: Plan,
    out: String,
    resume: bool,
    checkpoint_interval: u32,
    evaluation: EvaluationParameters,
}

impl Options {
    fn declare(parameters: &Parameters) -> anyhow::Result<Options> {
        let (preset, settings) = model_settings(parameters, &Defaults::default())?;
        let settings = training_settings(parameters, settings)?;
        let simulators = count(
            parameters,
            "simulators",
            1,
            1..=MAX_SIMULATORS,
            "number of environments in which the agent trains concurrently; if there are several, \
             they must be in the namespaces sim0, sim1, ...",
        )? as usize;
        let plan = Plan {
            scenario: scenario(parameters, &Defaults::default())?,
            episodes: count(
                parameters,
                "episodes",
                preset.episodes().into(),
                1..=MAX_EPISODES,
                "e_total in eq. 4: number of training episodes",
            )? as u32,
            seed: count(
                parameters,
                "seed",
                0,
                0..=LARGEST_SEED,
                "random seed of the training run; the same seed and parameters give bit-identical \
                 episodes and weights",
            )?,
            rooms: simulators,
        };
        let default_out = format!("runs/{}-{preset}-seed{}", plan.scenario, plan.seed);
        let out = declare(
            parameters,
            "out",
            default_out,
            "output directory of the run; unless resume is set, an earlier run in this directory \
             is kept under the same name with a number appended",
        )?;
        let resume = declare(
            parameters,
            "resume",
            false,
            "continue from the checkpoint in out; scenario, episodes, seed, simulators and the \
             hyperparameters must match those of the interrupted run",
        )?;
        let checkpoints = [RunDirectory::CHECKPOINT, RunDirectory::PREVIOUS_CHECKPOINT];
        if resume && !checkpoints.iter().any(|name| Path::new(&out).join(name).exists()) {
            anyhow::bail!(
                "parameter 'resume' is true, but there is no {} in {out} (expected: the directory of \
                 an interrupted training run)",
                RunDirectory::CHECKPOINT
            );
        }
        let checkpoint_interval = count(
            parameters,
            "checkpoint_interval",
            100,
            1..=10_000_000,
            "number of episodes between checkpoints; a checkpoint is also saved at the end, on \
             Ctrl-C and after an error, unless training diverged",
        )? as u32;
        let evaluation =
            EvaluationParameters::declare(parameters, "evaluation_episodes", "evaluation_seed", 0)?;
        Ok(Options { preset, settings, plan, out, resume, checkpoint_interval, evaluation })
    }

    /// Returns the namespaces of the simulators, relative to the node's namespace.
    fn namespaces(&self) -> Vec<String> {
        match self.plan.rooms {
            1 => vec![String::new()],
            simulators => (0..simulators).map(|index| format!("sim{index}")).collect(),
        }
    }

    /// Returns the run directory and the training state: a new state or, with `resume`, the state
    /// in the last checkpoint.
    fn begin(&self) -> anyhow::Result<(RunDirectory, Training)> {
        let out = Path::new(&self.out);
        if self.resume {
            let directory = RunDirectory::open(out)?;
            let training = saver::load(&directory, &self.plan, &self.settings)?;
            info!("resuming after {} of {} episodes", training.episode(), training.plan.episodes);
            return Ok((directory, training));
        }
        let (directory, moved) = RunDirectory::create(out)?;
        if let Some(moved) = moved.as_deref().and_then(Path::file_name) {
            let moved = out.with_file_name(moved);
            info!("moved the earlier run from {} to {}", out.display(), moved.display());
        }
        Ok((directory, Training::new(self.plan.clone(), self.settings.clone())?))
    }

    /// Creates the listener, without announcers.
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
            reported_episodes: training.episode(),
        })
    }
}

/// Trains in the environments.
fn run(
    training: &mut Training,
    environments: &mut [Simulator],
    listener: &mut TrainingListener,
) -> Result<(), TrainingError<SimulatorError>> {
    match environments {
        [environment] => std::thread::scope(|scope| {
            let environment = Background::start(scope, environment)
                .context("cannot start the environment thread")?;
            training.run(&mut [environment], listener)
        }),
        // With several environments, a request to one overlaps with work on the others.
        environments => training.run(environments, listener),
    }
}

/// Saves the training state, even after an error, unless training diverged. Returns whether
/// training is complete: `false` after a shutdown.
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
                "training stopped after {episode} episodes, saved in {out}; run the same command with \
                 --resume to continue"
            );
            Ok(false)
        }
        // Diverged weights must not replace the last good checkpoint.
        Err(error @ TrainingError::Diverged { .. }) => Err(error).context(format!(
            "training stopped after {episode} episodes; {out} keeps the last checkpoint"
        )),
        Err(error) => {
            let saved = match saver::write(training, directory) {
                Ok(()) => format!("saved in {out}"),
                Err(reason) => format!("not saved ({reason:#})"),
            };
            Err(error).context(format!("training stopped after {episode} episodes, {saved}"))
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

/// The evaluation images for the report.
#[derive(Default)]
struct EvaluationImages {
    frames: Vec<CaptionedFrame>,
    escapes: Option<EscapeFigures>,
}

/// Evaluates the policy, adds the result to `summary.json` and draws the figures. Returns `None` if
/// the node shuts down before the evaluation ends. `namespace` is the simulator's namespace.
fn evaluate_and_draw(
    mut evaluation: PolicyEvaluation,
    shortest: Option<&ShortestPaths>,
    namespace: &str,
    common: &Common,
    directory: &RunDirectory,
    summary: &mut Summary,
) -> anyhow::Result<Option<EvaluationImages>> {
    let Some(evaluated) = evaluation.run(shortest)? else {
        return Ok(None);
    };
    summary.evaluation = Some(evaluated.evaluation);
    directory.write_json("summary.json", &summary)?;
    let escapes = escapes::draw(&mut evaluation, namespace, common, directory)?;
    Ok(Some(EvaluationImages { frames: evaluated.frames, escapes }))
}

/// Writes `report.html` and, if there are enough episodes, the learning curve as an SVG file.
fn write_report(
    training: &Training,
    summary: &Summary,
    images: &EvaluationImages,
    directory: &RunDirectory,
) -> anyhow::Result<()> {
    let records: Vec<_> = training.progress.records.iter().cloned().collect();
    let report = Report {
        run: facts(summary),
        records: &records,
        evaluation: summary.evaluation.as_ref(),
        frames: &images.frames,
        escapes: images.escapes.as_ref(),
    };
    if let Some(curve) = report.learning_curve()? {
        let figures = RunDirectory::open(&directory.file("figures"))?;
        figures.write("learning_curve.svg", curve.as_bytes())?;
    }
    Ok(directory.write("report.html", report.to_html()?.as_bytes())?)
}

fn facts(summary: &Summary) -> RunSummary<'_> {
    RunSummary {
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
