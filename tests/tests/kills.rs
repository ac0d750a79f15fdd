//! Both nodes killed again and again in the middle of a training, which ends as if nothing had been.
//!
//! `EVAC_KILLS` says how often (default: 100).

use std::{
    fs,
    path::Path,
    time::{Duration, Instant, SystemTime},
};

use evac_tests::{
    Nodes, Outcome, PATIENCE,
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
        "evaluation_episodes:=0".to_owned(),
        // A checkpoint is always being written.
        "checkpoint_interval:=1".to_owned(),
    ];
    let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
    nodes.start_agent("train", &parameters);
}

fn start_simulator(nodes: &mut Nodes) {
    nodes.start_simulator(&[&format!("max_steps:={MAX_STEPS}")]);
}

fn written(checkpoint: &Path) -> Option<SystemTime> {
    fs::metadata(checkpoint).and_then(|metadata| metadata.modified()).ok()
}

#[test]
fn killed_at_any_moment_a_training_ends_as_if_it_had_never_been() {
    let kills: u32 =
        std::env::var("EVAC_KILLS").map_or(100, |kills| kills.parse().expect("a number"));
    // Every life of the agent is some episodes long, and some are left for the last one.
    let episodes = 20 * kills;
    let mut random = ChaCha8Rng::seed_from_u64(kills.into());
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    let checkpoint = out.join("checkpoint.safetensors");
    start_simulator(&mut nodes);
    start_agent(&mut nodes, &out, episodes, false);
    let mut killed = [0, 0];
    for _ in 0..kills {
        // It has taken up its work.
        let (before, end) = (written(&checkpoint), Instant::now() + PATIENCE);
        while written(&checkpoint) == before {
            assert!(Instant::now() < end, "nothing is saved:\n{}", nodes.log("agent_node"));
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(random.random_range(0..100)));
        if random.random_bool(0.25) {
            nodes.kill("sim_node");
            start_simulator(&mut nodes);
            killed[1] += 1;
        } else {
            nodes.kill("agent_node");
            start_agent(&mut nodes, &out, episodes, true);
            killed[0] += 1;
        }
    }
    nodes.succeed("agent_node", TRAINING);
    println!("killed: agent_node {} times, sim_node {} times", killed[0], killed[1]);
    let plan = Plan { scenario: "empty".to_owned(), episodes, seed: SEED, rooms: 1 };
    let undisturbed = Outcome::in_process(plan, Preset::Paper, MAX_STEPS, &nodes.path("here"));
    Outcome::left_in(&out).assert_is(&undisturbed);
    let names =
        fs::read_dir(&out).expect("a directory").map(|file| file.expect("a file").file_name());
    let unfinished = names.filter(|name| name.to_string_lossy().ends_with(".unfinished"));
    assert_eq!(unfinished.count(), 0, "what was half written is gone");
}

#[test]
fn evac_killed_twenty_times_in_each_way_leaves_nothing() {
    for kill in [Kill::Alone("KILL"), Kill::Alone("TERM"), Kill::Alone("HUP"), Kill::Group("INT")] {
        assert_leaves_nothing(kill, 20);
    }
}
