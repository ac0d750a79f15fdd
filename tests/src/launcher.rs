//! Checks that `evac` leaves no process behind when it is killed.

use std::{
    fs,
    os::unix::process::CommandExt,
    path::Path,
    process::{Child, Command},
    time::{Duration, Instant},
};

use learning::{settings::Preset, training::Plan};
use sim_node::world::WorldSettings;

use crate::{Nodes, Outcome, TIMEOUT, binary};

/// A signal that ends `evac`, such as `TERM`, and its recipients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kill {
    /// Sent to `evac` only.
    Alone(&'static str),
    /// Sent to `evac` and the nodes, as a terminal does on Ctrl-C.
    Group(&'static str),
}

/// Kills `evac` during a training run and resumes the training, `rounds` times. Asserts that no
/// node is left running after a kill, and that the final result matches that of an undisturbed
/// training run.
///
/// # Panics
///
/// Panics if a node is still running after [`TIMEOUT`], if the last run fails, or if the result
/// differs.
pub fn assert_leaves_nothing(kill: Kill, rounds: u32) {
    const EPISODES: u32 = 8;
    let nodes = Nodes::new();
    let out = nodes.path("run");
    let checkpoint = out.join("checkpoint.safetensors");
    for round in 0..rounds {
        let mut evac = start(&nodes, &out, EPISODES, checkpoint.exists());
        let group = evac.id();
        wait_until("both nodes are running", || nodes_of(group).len() == 2);
        // Hits a different phase of the training in each round.
        std::thread::sleep(Duration::from_millis(u64::from(round % 10) * 30));
        signal(kill, group);
        evac.wait().expect("a child process");
        wait_until("no node is running", || nodes_of(group).is_empty());
    }
    let status = start(&nodes, &out, EPISODES, checkpoint.exists()).wait();
    assert!(status.expect("a child process").success());
    let plan =
        Plan { scenario: task::seeds::MIXED.to_owned(), episodes: EPISODES, seed: 3, rooms: 1 };
    let max_steps = WorldSettings::default().max_steps;
    let undisturbed = Outcome::in_process(plan, Preset::Paper, max_steps, &nodes.path("here"));
    Outcome::read_from(&out).assert_identical(&undisturbed);
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

/// Returns the `stat` lines of the running nodes in a process group.
fn nodes_of(group: u32) -> Vec<String> {
    let processes = fs::read_dir("/proc").expect("/proc is mounted").map_while(Result::ok);
    let stats = processes.filter_map(|p| fs::read_to_string(p.path().join("stat")).ok());
    // proc_pid_stat(5): pid (comm) state ppid pgrp ...
    let is_node_of_group = |stat: &String| {
        let (name, rest) = stat.split_once(')').unwrap_or_default();
        let mut fields = rest.split_whitespace();
        let is_alive = fields.next() != Some("Z");
        let is_node = name.ends_with("_node");
        is_alive && is_node && fields.nth(1) == Some(group.to_string().as_str())
    };
    stats.filter(is_node_of_group).collect()
}

fn wait_until(description: &str, condition: impl Fn() -> bool) {
    let end = Instant::now() + TIMEOUT;
    while !condition() {
        assert!(Instant::now() < end, "not true within {TIMEOUT:?}: {description}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
