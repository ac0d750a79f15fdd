//! Kills both nodes repeatedly during a training run, which must end with the same result as an
//! undisturbed one.
//!
//! `EVAC_KILLS` sets the number of kills (default: 100).

use std::{
    fs,
    path::Path,
    time::{Duration, Instant, SystemTime},
};

use evac_tests::{
    Nodes, Outcome, TIMEOUT,
    launcher::{Kill, assert_leaves_nothing},
};
use learning::{settings::Preset, training::Plan};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const TRAINING: Duration = Duration::from_secs(600);
const MAX_STEPS: u32 = 60;
const SEED: u64 = 5;

fn start_agent(nodes: &mut Nodes, out: &Path, episodes: u32, resume: bool) {
    let parameters = [
        format!("out:='{}'", out.display()),
        format!("episodes:={episodes}"),
        format!("seed:={SEED}"),
        format!("resume:={resume}"),
        "preset:=paper".to_owned(),
        "scenario:=empty".to_owned(),
        "evaluation_episodes:=0".to_owned(),
        // Some kills then hit a checkpoint while it is being written.
        "checkpoint_interval:=1".to_owned(),
    ];
    let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
    nodes.start_agent("train", &parameters);
}

fn start_simulator(nodes: &mut Nodes) {
    nodes.start_simulator(&[&format!("max_steps:={MAX_STEPS}")]);
}

fn modified(checkpoint: &Path) -> Option<SystemTime> {
    fs::metadata(checkpoint).and_then(|metadata| metadata.modified()).ok()
}

#[test]
fn training_survives_kills_at_random_times() {
    let kills: u32 =
        std::env::var("EVAC_KILLS").map_or(100, |kills| kills.parse().expect("a number"));
    // Enough episodes for each run of the agent between two kills, and for the last run.
    let episodes = 20 * kills;
    let mut random = ChaCha8Rng::seed_from_u64(kills.into());
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    let checkpoint = out.join("checkpoint.safetensors");
    start_simulator(&mut nodes);
    start_agent(&mut nodes, &out, episodes, false);
    let (mut agent_kills, mut simulator_kills) = (0, 0);
    for _ in 0..kills {
        // A new checkpoint shows that the training has continued since the previous kill.
        let (before, end) = (modified(&checkpoint), Instant::now() + TIMEOUT);
        while modified(&checkpoint) == before {
            assert!(Instant::now() < end, "no new checkpoint:\n{}", nodes.log("agent_node"));
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(random.random_range(0..100)));
        if random.random_bool(0.25) {
            nodes.kill("sim_node");
            start_simulator(&mut nodes);
            simulator_kills += 1;
        } else {
            nodes.kill("agent_node");
            start_agent(&mut nodes, &out, episodes, true);
            agent_kills += 1;
        }
    }
    nodes.succeed("agent_node", TRAINING);
    println!("killed agent_node {agent_kills} times, sim_node {simulator_kills} times");
    let plan = Plan { scenario: "empty".to_owned(), episodes, seed: SEED, rooms: 1 };
    let undisturbed = Outcome::in_process(plan, Preset::Paper, MAX_STEPS, &nodes.path("here"));
    Outcome::read_from(&out).assert_identical(&undisturbed);
    let names =
        fs::read_dir(&out).expect("a directory").map(|file| file.expect("a file").file_name());
    let unfinished = names.filter(|name| name.to_string_lossy().ends_with(".unfinished"));
    assert_eq!(unfinished.count(), 0, "incomplete files are left behind");
}

#[test]
fn evac_killed_by_any_signal_leaves_no_process() {
    for kill in [Kill::Alone("KILL"), Kill::Alone("TERM"), Kill::Alone("HUP"), Kill::Group("INT")] {
        assert_leaves_nothing(kill, 20);
    }
}
