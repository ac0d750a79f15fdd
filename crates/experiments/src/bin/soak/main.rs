//! The soak test: a training run of a million steps over a network that loses, duplicates and
//! delays frames and is cut at intervals. Counts lost and duplicated steps and monitors the
//! resource usage of both nodes. `launch_scripts/soak.sh` runs this program.

mod report;
mod resources;
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
use sim_node::world::WorldSettings;

use self::{
    report::Report,
    resources::{ResourceUsage, Sample},
    watcher::Watcher,
};

/// Number of steps after which both nodes have allocated what they need. From then on, their memory
/// must not grow by more than 5 %, and their number of open files must not grow at all.
const SETTLED_STEPS: u64 = 50_000;
/// Minimum number of steps between two samples of the nodes' resource usage.
const SAMPLE_STEPS: u64 = 20_000;
const MAX_STEPS: u32 = 100;
const SEED: u64 = 0;
const PRESET: Preset = Preset::Paper;
/// Makes each move random with a probability of at least 0.5. Episodes are therefore long, and a
/// million steps need few episodes. The agent keeps a record of every episode in memory, so fewer
/// episodes mean less memory growth.
const MIN_EPSILON: f64 = 0.5;
/// A randomly drawn scenario for each episode.
const SCENARIO: &str = "mixed";
/// Duration of each network cut.
const CUT: Duration = Duration::from_secs(5);
/// The soak test fails if no step is executed for this long. RustDDS drops a silent participant
/// only after 50 s.
const STEP_TIMEOUT: Duration = Duration::from_secs(120);
/// Time to wait for the last report on `/diagnostics`. Reports are published once per second.
const LAST_REPORT: Duration = Duration::from_secs(3);

/// Trains for a million steps over an unreliable network. Fails if a step is lost or executed
/// twice, if the result differs from that of the same training run without a network, or if a
/// node's memory or number of open files grows. Creates two network namespaces with a relay between
/// them; needs root, Linux, util-linux and iproute2.
#[derive(Parser)]
struct CommandLine {
    /// Number of training episodes, each in a randomly drawn scenario
    #[arg(long, default_value_t = 28_000)]
    episodes: u32,
    /// Probability that a frame is lost
    #[arg(long, default_value_t = 0.002)]
    loss: f64,
    /// Probability that a frame is duplicated
    #[arg(long, default_value_t = 0.01)]
    repetition: f64,
    /// Maximum delay of a frame, in milliseconds; delays are random, so frames can be reordered
    #[arg(long, default_value_t = 0.2)]
    delay: f64,
    /// Number of steps between network outages, each of which lasts 5 s
    #[arg(long, default_value_t = 100_000)]
    cut_interval: u64,
    /// Output file (JSON)
    #[arg(long, default_value = "soak.json")]
    out: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let command_line = CommandLine::parse();
    let CommandLine { episodes, loss, repetition, cut_interval, .. } = command_line;
    for (name, chance) in [("loss", loss), ("repetition", repetition)] {
        ensure!((0.0..1.0).contains(&chance), "--{name} is {chance} (expected: 0 to less than 1)");
    }
    ensure!(cut_interval > 0, "--cut-interval is 0 (expected: at least 1)");
    let delay = Duration::try_from_secs_f64(command_line.delay / 1000.0)
        .map_err(|error| anyhow!("--delay is {}: {error}", command_line.delay))?;
    Network::check_requirements()
        .map_err(|reason| anyhow!("cannot emulate a network: {reason}"))?;

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
        format!("epsilon_min:={MIN_EPSILON}"),
        // Without an evaluation, every step that the simulator counts is a training step.
        "evaluation_episodes:=0".to_owned(),
    ];
    let parameters = parameters.each_ref().map(String::as_str);
    nodes.start_agent_on(here, "agent_node", "train", &parameters);

    let begin = Instant::now();
    let bar = progress_bar(episodes);
    let (mut samples, mut last, mut cuts) = (Vec::<Sample>::new(), None, 0);
    let (mut latest_steps, mut latest_step_at) = (0, Instant::now());
    while nodes.ended("agent_node").is_none() {
        std::thread::sleep(Duration::from_millis(200));
        let steps = watcher.steps();
        bar.set_position(watcher.episodes());
        if steps > latest_steps {
            (latest_steps, latest_step_at) = (steps, Instant::now());
        }
        let is_stepping = latest_step_at.elapsed() < STEP_TIMEOUT;
        ensure!(is_stepping, "no step within {STEP_TIMEOUT:?}:\n{}", nodes.log("agent_node"));
        let [sim, agent] = ["sim_node", "agent_node"].map(|name| resource_usage(&mut nodes, name));
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
            network.set_partitioned(true);
            std::thread::sleep(CUT);
            network.set_partitioned(false);
        }
    }
    bar.finish_and_clear();
    nodes.succeed("agent_node", Duration::ZERO);
    let took = begin.elapsed();
    std::thread::sleep(LAST_REPORT);
    ensure!(nodes.ended("sim_node").is_none(), "sim_node exited:\n{}", nodes.log("sim_node"));

    eprintln!("repeating the training run in one process without a network ...");
    let outcome = Outcome::read_from(&out);
    let plan = Plan { scenario: SCENARIO.to_owned(), episodes, seed: SEED, rooms: 1 };
    let mut settings = PRESET.settings();
    settings.exploration.epsilon.minimum = MIN_EPSILON;
    let world = WorldSettings { max_steps: MAX_STEPS, ..WorldSettings::default() };
    let undisturbed = Outcome::with_settings(plan, settings, world, &nodes.path("here"));
    let steps = outcome.steps();
    let too_short = || {
        anyhow!(
            "--episodes is {episodes}: {steps} steps in total (expected: at least {SETTLED_STEPS})"
        )
    };
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
    println!("\nWrote {}.", command_line.out.display());
    report.check()
}

/// Returns the resource usage of a node; `None` once its process has exited.
fn resource_usage(nodes: &mut Nodes, name: &str) -> Option<ResourceUsage> {
    let (memory_mb, handles) = (nodes.memory_mb(name), nodes.handles(name)?);
    memory_mb.is_finite().then_some(ResourceUsage { memory_mb, handles })
}

fn progress_bar(episodes: u32) -> ProgressBar {
    let template = "{msg} {pos}/{len} {bar:30.green/blue} {elapsed} ({eta} left)";
    let style = ProgressStyle::with_template(template).expect("the template is well-formed");
    ProgressBar::new(episodes.into()).with_style(style).with_message("episodes")
}
