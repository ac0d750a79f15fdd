//! Whole trainings: in this process, and by the two nodes over DDS.

use std::{fs, time::Duration};

use experiments::{Nodes, Room, Silent};
use learning::{
    settings::Preset,
    training::{Plan, Training},
};
use serde_json::Value;
use sim_node::world::WorldSettings;

const EPISODES: u32 = 1000;
/// Trainings over DDS; an odd number has a middle.
const TRAININGS: usize = 3;
const PATIENCE: Duration = Duration::from_secs(1800);

/// The preset `paper` in the empty room, 1,000 episodes.
pub struct TrainingFigures {
    pub steps: u64,
    pub in_process_steps_per_s: f64,
    pub wall_s: f64,
    pub over_dds_steps_per_s: f64,
    /// Mean of an update within the training over DDS.
    pub update_us: f64,
    /// Resident memory at the end of the training, in MB.
    pub sim_rss_mb: f64,
    pub agent_rss_mb: f64,
}

impl TrainingFigures {
    /// The wall time in units of the updates' time.
    pub fn wall_ratio(&self) -> f64 {
        self.wall_s / self.updates_s()
    }

    /// What all updates took.
    pub fn updates_s(&self) -> f64 {
        self.steps as f64 * self.update_us / 1e6
    }
}

/// Of several trainings over DDS, which all take the same steps, the one in the middle.
pub fn measure() -> anyhow::Result<TrainingFigures> {
    let plan = Plan { scenario: "empty".into(), episodes: EPISODES, seed: 0, rooms: 1 };
    let mut training = Training::new(plan, Preset::Paper.settings())?;
    training.run(&mut [Room::new(WorldSettings::default())], &mut Silent)?;
    let mut trainings = Vec::new();
    for _ in 0..TRAININGS {
        trainings.push(measure_over_dds(&training)?);
    }
    trainings.sort_by(|a, b| a.wall_ratio().total_cmp(&b.wall_ratio()));
    Ok(trainings.swap_remove(TRAININGS / 2))
}

/// `training` is the same training in this process.
fn measure_over_dds(training: &Training) -> anyhow::Result<TrainingFigures> {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    nodes.start_simulator(&[]);
    let parameters = [
        format!("out:='{}'", out.display()),
        format!("episodes:={EPISODES}"),
        "preset:=paper".to_owned(),
        "evaluation_episodes:=0".to_owned(),
    ];
    let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
    nodes.start_agent("train", &parameters);
    let agent_rss_mb = nodes.greatest_memory_mb("agent_node", PATIENCE);
    let sim_rss_mb = nodes.memory_mb("sim_node");
    nodes.succeed("agent_node", PATIENCE);
    let summary: Value = serde_json::from_slice(&fs::read(out.join("summary.json"))?)?;
    let number = |name: &str| summary[name].as_f64().unwrap_or(f64::NAN);
    anyhow::ensure!(
        number("steps") as u64 == training.progress.total_steps,
        "over DDS the training took other steps than in this process"
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
