//! The pair over a network that loses, repeats, delays and is cut off, for a million steps: what was
//! lost or repeated of them, and what the nodes hold. `launch_scripts/soak.sh` runs it.

mod report;
mod watcher;

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use anyhow::{anyhow, ensure};
use clap::Parser;
use experiments::{
    Nodes, Outcome,
    network::{Faults, Network},
};
use indicatif::{ProgressBar, ProgressStyle};
use learning::{settings::Preset, training::Plan};
use ros_runtime::{
    discovery::{Discovery, Range},
    security::Security,
};

use self::{report::Report, watcher::Watcher};

/// Both nodes have all that they need after so many steps; from here on they should not grow.
const SETTLED_STEPS: u64 = 50_000;
/// How many steps lie between two looks at what the nodes hold.
const SAMPLE_STEPS: u64 = 20_000;
const MAX_STEPS: u32 = 100;
const SEED: u64 = 0;
const PRESET: Preset = Preset::Paper;
/// Half of the moves are random, so that episodes are long: the agent keeps a record of each.
const LEAST_EPSILON: f64 = 0.5;
/// All of them, one after the other.
const SCENARIO: &str = "mixed";
/// How long the network is cut off each time.
const CUT: Duration = Duration::from_secs(5);
/// No step, for so long, is a failure: RustDDS counts somebody who is gone for 50 s.
const STANDSTILL: Duration = Duration::from_secs(120);
/// A report on /diagnostics comes each second; the last one, after the last step.
const LAST_REPORT: Duration = Duration::from_secs(3);

/// A training of a million steps over a bad network: which steps were lost or repeated, whether the result
/// is that of the same training without a network, and whether the nodes grow. It makes two network
/// namespaces and a relay between them, for which it needs root, Linux, util-linux and iproute2.
#[derive(Parser)]
struct CommandLine {
    /// Training episodes, each in a scenario that is drawn for it
    #[arg(long, default_value_t = 28_000)]
    episodes: u32,
    /// The chance that a frame of the network is lost
    #[arg(long, default_value_t = 0.002)]
    loss: f64,
    /// The chance that a frame comes twice
    #[arg(long, default_value_t = 0.01)]
    repetition: f64,
    /// The longest delay of a frame, in milliseconds; each has its own, so they overtake each other
    #[arg(long, default_value_t = 0.2)]
    delay: f64,
    /// The network is cut off for 5 s after so many steps, again and again
    #[arg(long, default_value_t = 100_000)]
    cut_interval: u64,
    /// Where the figures go, as JSON
    #[arg(long, default_value = "soak.json")]
    out: PathBuf,
}

/// What a node holds.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Holdings {
    /// Resident, in MB of 10^6 bytes.
    pub memory_mb: f64,
    /// Open files, sockets and the like.
    pub handles: usize,
}

/// What both nodes hold, after so many steps.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Sample {
    /// Those that the simulator has executed.
    pub steps: u64,
    /// `sim_node`.
    pub sim: Holdings,
    /// `agent_node`.
    pub agent: Holdings,
}

fn main() -> anyhow::Result<()> {
    let command_line = CommandLine::parse();
    let CommandLine { episodes, loss, repetition, cut_interval, .. } = command_line;
    for (name, chance) in [("loss", loss), ("repetition", repetition)] {
        ensure!((0.0..1.0).contains(&chance), "--{name} is {chance}: expected 0 to less than 1");
    }
    ensure!(cut_interval > 0, "--cut-interval is 0: expected a number of steps");
    let delay = Duration::try_from_secs_f64(command_line.delay / 1000.0)
        .map_err(|error| anyhow!("--delay is {}: {error}", command_line.delay))?;
    Network::is_possible().map_err(|reason| anyhow!("no network of our own here: {reason}"))?;

    let network = Network::new(Faults { loss, repetition, delay }, SEED)?;
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    let [here, there] = network.hosts();
    let discovery = Discovery { range: Range::Subnet, ..nodes.discovery(Security::Off) };
    let watcher = Watcher::on(there, discovery)?;
    let max_steps = format!("max_steps:={MAX_STEPS}");
    nodes.start_simulator_on(there, "sim_node", &[&max_steps]);
    let parameters = [
        format!("out:='{}'", out.display()),
        format!("episodes:={episodes}"),
        format!("seed:={SEED}"),
        format!("scenario:={SCENARIO}"),
        format!("preset:={PRESET}"),
        format!("epsilon_min:={LEAST_EPSILON}"),
        // Nothing but the training, and it makes each of the simulator's steps.
        "evaluation_episodes:=0".to_owned(),
    ];
    let parameters = parameters.each_ref().map(String::as_str);
    nodes.start_agent_on(here, "agent_node", "train", &parameters);

    let begin = Instant::now();
    let bar = progress_bar(episodes);
    let (mut samples, mut last, mut cuts) = (Vec::<Sample>::new(), None, 0);
    let mut progress = (0, Instant::now());
    while nodes.ended("agent_node").is_none() {
        std::thread::sleep(Duration::from_millis(200));
        let steps = watcher.steps();
        bar.set_position(watcher.episodes());
        if steps > progress.0 {
            progress = (steps, Instant::now());
        }
        let is_going_on = progress.1.elapsed() < STANDSTILL;
        ensure!(is_going_on, "nothing goes on:\n{}", nodes.log("agent_node"));
        let [sim, agent] = ["sim_node", "agent_node"].map(|name| holdings(&mut nodes, name));
        if let (Some(sim), Some(agent)) = (sim, agent) {
            let sample = Sample { steps, sim, agent };
            let due = samples.last().map_or(SETTLED_STEPS, |sample| sample.steps + SAMPLE_STEPS);
            if steps >= due {
                samples.push(sample);
            }
            last = Some(sample);
        }
        if steps >= (cuts + 1) * cut_interval {
            cuts += 1;
            network.set_cut(true);
            std::thread::sleep(CUT);
            network.set_cut(false);
        }
    }
    bar.finish_and_clear();
    nodes.succeed("agent_node", Duration::ZERO);
    let took = begin.elapsed();
    std::thread::sleep(LAST_REPORT);
    ensure!(nodes.ended("sim_node").is_none(), "sim_node has ended:\n{}", nodes.log("sim_node"));

    eprintln!("the same training once more, in one process and without a network ...");
    let outcome = Outcome::left_in(&out);
    let plan = Plan { scenario: SCENARIO.to_owned(), episodes, seed: SEED, rooms: 1 };
    let mut settings = PRESET.settings();
    settings.exploration.epsilon.minimum = LEAST_EPSILON;
    let undisturbed = Outcome::with_settings(plan, settings, MAX_STEPS, &nodes.path("here"));
    let steps = outcome.steps();
    let too_short =
        || anyhow!("{episodes} episodes are {steps} steps, less than {SETTLED_STEPS}: give more");
    let report = Report {
        steps,
        executed: watcher.steps(),
        is_as_undisturbed: outcome == undisturbed,
        traffic: network.traffic(),
        cuts,
        longest_latency: watcher.longest_latency(),
        took,
        first: *samples.first().ok_or_else(too_short)?,
        last: last.ok_or_else(too_short)?,
        samples,
    };
    print!("{}", report.table());
    std::fs::write(&command_line.out, report.json()?)?;
    println!("\nThe figures are in {}.", command_line.out.display());
    report.check()
}

fn holdings(nodes: &mut Nodes, name: &str) -> Option<Holdings> {
    let (memory_mb, handles) = (nodes.memory_mb(name), nodes.handles(name)?);
    memory_mb.is_finite().then_some(Holdings { memory_mb, handles })
}

fn progress_bar(episodes: u32) -> ProgressBar {
    let template = "{msg} {pos}/{len} {bar:30.green/blue} {elapsed} (left {eta})";
    let style = ProgressStyle::with_template(template).expect("the template is well-formed");
    ProgressBar::new(episodes.into()).with_style(style).with_message("episodes")
}
