//! `evac` as a process, and what is left when it is killed.

use std::{
    fs,
    os::unix::process::CommandExt,
    path::Path,
    process::{Child, Command},
    time::{Duration, Instant},
};

use learning::{settings::Preset, training::Plan};
use sim_node::world::WorldSettings;

use crate::{Nodes, Outcome, PATIENCE, binary};

/// A signal that `evac` is killed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kill {
    /// To `evac` alone.
    Alone(&'static str),
    /// To `evac` and the nodes, as a terminal does on Ctrl-C.
    Group(&'static str),
}

/// Kills `evac` in the middle of a training again and again; each time no process may be left, and the
/// training must go on. Its result is that of an undisturbed one.
pub fn assert_leaves_nothing(kill: Kill, rounds: u32) {
    const EPISODES: u32 = 8;
    let nodes = Nodes::new();
    let out = nodes.path("run");
    let checkpoint = out.join("checkpoint.safetensors");
    for round in 0..rounds {
        let mut evac = start(&nodes, &out, EPISODES, checkpoint.exists());
        let group = evac.id();
        wait_until("the nodes run", || nodes_of(group).len() == 2);
        // At another moment each time.
        std::thread::sleep(Duration::from_millis(u64::from(round % 10) * 30));
        signal(kill, group);
        evac.wait().expect("it is our child");
        wait_until("no node is left", || nodes_of(group).is_empty());
    }
    let status = start(&nodes, &out, EPISODES, checkpoint.exists()).wait();
    assert!(status.expect("it is our child").success());
    let plan = Plan { scenario: "empty".to_owned(), episodes: EPISODES, seed: 3, rooms: 1 };
    let max_steps = WorldSettings::default().max_steps;
    let undisturbed = Outcome::in_process(plan, Preset::Paper, max_steps, &nodes.path("here"));
    Outcome::left_in(&out).assert_is(&undisturbed);
}

fn start(nodes: &Nodes, out: &Path, episodes: u32, resume: bool) -> Child {
    let mut evac = nodes.command(binary("evac"));
    evac.process_group(0)
        .args(["train", "--preset", "paper", "--seed", "3", "--evaluation-episodes", "0"])
        .args(["--checkpoint-interval", "1", "--episodes", &episodes.to_string(), "--out"])
        .arg(out)
        .args(resume.then_some("--resume"));
    evac.spawn().expect("evac runs")
}

fn signal(kill: Kill, group: u32) {
    let (name, to) = match kill {
        Kill::Alone(name) => (name, group.to_string()),
        Kill::Group(name) => (name, format!("-{group}")),
    };
    let status = Command::new("kill").args(["-s", name, "--", &to]).status();
    assert!(status.expect("kill runs").success());
}

/// The nodes in a process group that have not ended.
fn nodes_of(group: u32) -> Vec<String> {
    let processes = fs::read_dir("/proc").expect("there is /proc").map_while(Result::ok);
    let stats = processes.filter_map(|p| fs::read_to_string(p.path().join("stat")).ok());
    // number (name) state parent group ...
    let is_of_group = |stat: &String| {
        let (name, rest) = stat.split_once(')').unwrap_or_default();
        let mut fields = rest.split_whitespace();
        let is_alive = fields.next() != Some("Z");
        let is_node = name.ends_with("_node");
        is_alive && is_node && fields.nth(1) == Some(group.to_string().as_str())
    };
    stats.filter(is_of_group).collect()
}

fn wait_until(what: &str, is_so: impl Fn() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < end, "{what}: not within {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
