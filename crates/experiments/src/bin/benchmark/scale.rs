//! Measures training runs over DDS with several simulators in parallel. Their moves take time, as a
//! robot's do.

use std::{fs, time::Duration};

use experiments::Nodes;
use serde_json::Value;

/// Duration of a move, in seconds.
pub const MOTION_TIME_S: f64 = 0.01;
const ROOMS: [usize; 4] = [1, 2, 4, 8];
const EPISODES: u32 = 200;
const TRAINING_TIMEOUT: Duration = Duration::from_secs(3600);
/// A training run succeeds once at least [`SUCCESSES`] of the last [`RECENT`] episodes took at most
/// [`SUCCESS_STEPS`] steps each.
const SUCCESSES: usize = 45;
const RECENT: usize = 50;
/// Maximum number of steps in a successful episode.
pub const SUCCESS_STEPS: u64 = 50;

/// The measurements of one training run.
pub struct ScaleFigures {
    /// Number of simulators.
    pub rooms: usize,
    pub steps: u64,
    pub wall_s: f64,
    pub steps_per_s: f64,
    /// Time until the training run succeeds, in seconds; `None` if it never does.
    pub success_s: Option<f64>,
}

pub fn measure() -> anyhow::Result<Vec<ScaleFigures>> {
    ROOMS.into_iter().map(measure_with).collect()
}

fn measure_with(rooms: usize) -> anyhow::Result<ScaleFigures> {
    let mut nodes = Nodes::new();
    let motion_time = format!("motion_time:={MOTION_TIME_S}");
    for room in 0..rooms {
        // The namespaces are those that launch_scripts/train.sh uses.
        let namespace = match rooms {
            1 => "__ns:=/".to_owned(),
            _ => format!("__ns:=/sim{room}"),
        };
        let arguments = ["--ros-args", "-r", &namespace, "-p", &motion_time];
        nodes.start_beside("sim_node", &format!("sim_node{room}"), &arguments);
    }
    let out = nodes.path("run");
    let parameters = [
        format!("out:='{}'", out.display()),
        format!("simulators:={rooms}"),
        format!("episodes:={EPISODES}"),
        "preset:=paper".to_owned(),
        "scenario:=empty".to_owned(),
        "evaluation_episodes:=0".to_owned(),
    ];
    let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
    nodes.start_agent("train", &parameters);
    nodes.succeed("agent_node", TRAINING_TIMEOUT);
    let summary: Value = serde_json::from_slice(&fs::read(out.join("summary.json"))?)?;
    let number = |name: &str| summary[name].as_f64().unwrap_or(f64::NAN);
    let (steps, wall_s) = (number("steps"), number("wall_s"));
    // Steps per episode; the file lists episodes in the order in which they ended.
    let mut episodes = Vec::new();
    for line in fs::read_to_string(out.join("episodes.csv"))?.lines().skip(1) {
        episodes.push(line.split(',').nth(1).unwrap_or_default().parse::<u64>()?);
    }
    let successful = episodes
        .windows(RECENT)
        .position(|recent| recent.iter().filter(|s| **s <= SUCCESS_STEPS).count() >= SUCCESSES);
    let success_s = successful.map(|first| {
        let until: u64 = episodes[..first + RECENT].iter().sum();
        wall_s * until as f64 / steps
    });
    let steps_per_s = number("steps_per_s");
    Ok(ScaleFigures { rooms, steps: steps as u64, wall_s, steps_per_s, success_s })
}
