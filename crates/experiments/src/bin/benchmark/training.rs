//! Measures complete training runs, in this process and with the two nodes over DDS.

use std::{fs, time::Duration};

use experiments::{Nodes, NullListener, Room};
use learning::{
    settings::Preset,
    training::{Plan, Training},
};
use serde_json::Value;
use sim_node::world::WorldSettings;

const EPISODES: u32 = 1000;
/// Number of training runs over DDS; odd, so that one of them is the median.
const TRAININGS: usize = 3;
const TRAINING_TIMEOUT: Duration = Duration::from_secs(1800);

/// The measurements of a training run with the preset `paper`, the scenario `empty` and 1,000
/// episodes.
pub struct TrainingFigures {
    pub steps: u64,
    pub in_process_steps_per_s: f64,
    pub wall_s: f64,
    pub over_dds_steps_per_s: f64,
    /// Mean time per update during training over DDS, in microseconds.
    pub update_us: f64,
    /// Resident memory of `sim_node` at the end of training, in MB.
    pub sim_rss_mb: f64,
    /// Peak resident memory of `agent_node` during training, in MB.
    pub agent_rss_mb: f64,
}

impl TrainingFigures {
    /// Returns the wall time divided by the total update time.
    pub fn wall_ratio(&self) -> f64 {
        self.wall_s / self.updates_s()
    }

    /// Returns the total update time, in seconds.
    pub fn updates_s(&self) -> f64 {
        self.steps as f64 * self.update_us / 1e6
    }
}

/// Measures `TRAININGS` training runs over DDS, which all take the same steps. Returns the one
/// with the median [wall ratio](TrainingFigures::wall_ratio).
pub fn measure() -> anyhow::Result<TrainingFigures> {
    let plan = Plan { scenario: "empty".into(), episodes: EPISODES, seed: 0, rooms: 1 };
    let mut training = Training::new(plan, Preset::Paper.settings())?;
    training.run(&mut [Room::new(WorldSettings::default())], &mut NullListener)?;
    let mut trainings = Vec::new();
    for _ in 0..TRAININGS {
        trainings.push(measure_over_dds(&training)?);
    }
    trainings.sort_by(|a, b| a.wall_ratio().total_cmp(&b.wall_ratio()));
    Ok(trainings.swap_remove(TRAININGS / 2))
}

/// Trains over DDS and checks that this takes as many steps as `training`, the same training run in
/// this process.
fn measure_over_dds(training: &Training) -> anyhow::Result<TrainingFigures> {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    nodes.start_simulator(&[]);
    let parameters = [
        format!("out:='{}'", out.display()),
        format!("episodes:={EPISODES}"),
        "preset:=paper".to_owned(),
        "scenario:=empty".to_owned(),
        "evaluation_episodes:=0".to_owned(),
    ];
    let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
    nodes.start_agent("train", &parameters);
    let agent_rss_mb = nodes.peak_memory_mb("agent_node", TRAINING_TIMEOUT);
    let sim_rss_mb = nodes.memory_mb("sim_node");
    nodes.succeed("agent_node", TRAINING_TIMEOUT);
    let summary: Value = serde_json::from_slice(&fs::read(out.join("summary.json"))?)?;
    let number = |name: &str| summary[name].as_f64().unwrap_or(f64::NAN);
    anyhow::ensure!(
        number("steps") as u64 == training.progress.total_steps,
        "the training run took {} steps over DDS (expected: {}, as in this process)",
        number("steps"),
        training.progress.total_steps
    );
    Ok(TrainingFigures {
        steps: training.progress.total_steps,
        in_process_steps_per_s: training.steps_per_s(),
        wall_s: number("wall_s"),
        over_dds_steps_per_s: number("steps_per_s"),
        update_us: number("update_us"),
        sim_rss_mb,
        agent_rss_mb,
    })
}
