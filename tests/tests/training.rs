//! Training runs with the real nodes. The result is bit-identical however the training is run,
//! interrupted or disturbed.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

use evac_msgs::{ActionCommand, EpisodeStatus, QValues, TrainingStatus};
use evac_tests::{Nodes, Outcome, TIMEOUT};
use learning::{settings::Preset, training::Plan};
use ros_interfaces::builtin_interfaces::Time;
use ros_runtime::{
    node::reliable,
    parameters::{ParameterClient, ParameterValue},
};

/// Timeout of a training run; ample for its few hundred steps.
const TRAINING: Duration = Duration::from_secs(300);
/// Keeps the episodes of an untrained agent short.
const MAX_STEPS: u32 = 60;
const EPISODES: u32 = 12;
const SEED: u64 = 5;

/// Performs the same training run in this process.
fn in_process(scenario: &str, rooms: usize, directory: &Path) -> Outcome {
    in_process_with(Preset::default(), scenario, rooms, directory)
}

fn in_process_with(preset: Preset, scenario: &str, rooms: usize, directory: &Path) -> Outcome {
    Outcome::in_process(plan(scenario, rooms), preset, MAX_STEPS, directory)
}

fn plan(scenario: &str, rooms: usize) -> Plan {
    Plan { scenario: scenario.to_owned(), episodes: EPISODES, seed: SEED, rooms }
}

fn start_agent(nodes: &mut Nodes, out: &Path, scenario: &str, more: &[&str]) {
    let (out, episodes) = (format!("out:='{}'", out.display()), format!("episodes:={EPISODES}"));
    let (seed, scenario) = (format!("seed:={SEED}"), format!("scenario:={scenario}"));
    let own = [&out, &episodes, &seed, &scenario, "evaluation_episodes:=5", "max_steps:=20"];
    nodes.start_agent("train", &[&own, more].concat());
}

fn start_simulator(nodes: &mut Nodes) {
    nodes.start_simulator(&[&format!("max_steps:={MAX_STEPS}")]);
}

#[test]
fn training_over_dds_equals_training_in_process() {
    for (preset, scenario) in [
        (Preset::Paper, "empty"),
        (Preset::Paper, "three_moving"),
        (Preset::Robust, "concave"),
        (Preset::Robust, "mixed"),
    ] {
        let mut nodes = Nodes::new();
        let out = nodes.path("run");
        start_simulator(&mut nodes);
        start_agent(&mut nodes, &out, scenario, &[&format!("preset:={preset}")]);
        nodes.succeed("agent_node", TRAINING);
        let here = in_process_with(preset, scenario, 1, &nodes.path("here"));
        Outcome::read_from(&out).assert_identical(&here);
    }
}

#[test]
fn training_with_several_simulators_equals_training_in_process() {
    const SIMULATORS: usize = 3;
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    for index in 0..SIMULATORS {
        let namespace = format!("__ns:=/sim{index}");
        let max_steps = format!("max_steps:={MAX_STEPS}");
        let arguments = ["--ros-args", "-r", &namespace, "-p", &max_steps];
        nodes.start_beside("sim_node", &format!("sim{index}"), &arguments);
    }
    let simulators = format!("simulators:={SIMULATORS}");
    start_agent(&mut nodes, &out, "three_moving", &[&simulators]);
    nodes.succeed("agent_node", TRAINING);
    let here = in_process("three_moving", SIMULATORS, &nodes.path("here"));
    Outcome::read_from(&out).assert_identical(&here);
}

/// The simulator receives the actions through the service and does not execute published actions.
#[test]
fn training_publishes_actions_and_q_values() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    start_simulator(&mut nodes);
    let watcher = nodes.client();
    let actions = watcher.create_subscription::<ActionCommand>("action", reliable(1000));
    let actions = actions.expect("a subscription");
    let statuses = watcher.create_subscription::<EpisodeStatus>("episode", reliable(1000));
    let statuses = statuses.expect("a subscription");
    let q_values = watcher.create_subscription::<QValues>("q_values", reliable(1000));
    let q_values = q_values.expect("a subscription");
    // The preset `robust` would mask actions already tried from the same image.
    start_agent(&mut nodes, &out, "empty", &["preset:=paper"]);
    watcher.block_on(async {
        // Once the watcher has been discovered, it receives a command for every step, in order.
        for _ in 0..50 {
            let next = tokio::time::timeout(TIMEOUT, actions.async_take()).await;
            let (command, _) = next.expect("a command").expect("a valid command");
            assert!(command.sent_by_service);
            loop {
                let next = tokio::time::timeout(TIMEOUT, statuses.async_take()).await;
                let (status, _) = next.expect("a status").expect("a valid status");
                // A command carries the stamp of the image that it is based on. The first status
                // with a later stamp reports its step.
                if status.step > 0 && status.header.stamp > command.header.stamp {
                    assert_eq!(status.action, command.action);
                    break;
                }
            }
        }
        // The action has the largest Q-value, unless it is exploratory.
        for _ in 0..50 {
            let next = tokio::time::timeout(TIMEOUT, q_values.async_take()).await;
            let (message, _) = next.expect("Q-values").expect("valid Q-values");
            let largest = message.values.iter().copied().fold(f32::MIN, f32::max);
            let chosen = message.values[usize::from(message.action)];
            assert!(message.explored || chosen == largest, "{message:?}");
        }
    });
    nodes.succeed("agent_node", TRAINING);
}

/// Sets the parameter at the start and while the node is running.
#[test]
fn use_sim_time_selects_the_clock_of_the_agent() {
    // Separates the two clocks, in seconds: wall time is above it; simulated time starts at 0 and
    // stays below it.
    const THRESHOLD_S: i32 = 1_000_000_000;
    let mut nodes = Nodes::new();
    let out = format!("out:='{}'", nodes.path("run").display());
    start_simulator(&mut nodes);
    let mut watcher = nodes.client();
    let statuses = watcher.create_subscription::<TrainingStatus>("training_status", reliable(1000));
    let statuses = statuses.expect("a subscription");
    nodes.start_agent("train", &["episodes:=100000", &out, "use_sim_time:=true"]);
    let parameters = ParameterClient::new(&mut watcher, "agent_node").expect("a client");
    watcher.block_on(async {
        let next_stamp = async || {
            let next = tokio::time::timeout(TIMEOUT, statuses.async_take()).await;
            next.expect("a status").expect("a valid status").0.header.stamp
        };
        let mut latest = next_stamp().await;
        for _ in 0..20 {
            let stamp = next_stamp().await;
            assert!(stamp.sec < THRESHOLD_S && stamp >= latest, "{stamp:?} after {latest:?}");
            latest = stamp;
        }
        assert!(latest > Time::default());
        for (use_sim_time, clock) in [(false, "wall time"), (true, "simulated time")] {
            let value = ParameterValue::Bool(use_sim_time);
            let set = parameters.set("use_sim_time", value, TIMEOUT).await;
            assert_eq!(set, Ok(Ok(())));
            let end = Instant::now() + TIMEOUT;
            while (next_stamp().await.sec < THRESHOLD_S) != use_sim_time {
                assert!(Instant::now() < end, "stamps do not switch to {clock}");
            }
        }
    });
}

#[test]
fn a_run_writes_its_files_and_can_be_repeated_from_its_config() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    // The agent starts first and waits for the simulator.
    start_agent(&mut nodes, &out, "one_cylinder", &["epsilon_min:=0.2"]);
    nodes.wait_for_log("agent_node", "waiting for the service /reset");
    start_simulator(&mut nodes);
    nodes.succeed("agent_node", TRAINING);
    let first = Outcome::read_from(&out);

    let json = |name: &str| -> serde_json::Value {
        let text = fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        serde_json::from_str(&text).expect("JSON")
    };
    let summary = json("summary.json");
    assert_eq!(summary["scenario"], "one_cylinder");
    assert_eq!(summary["preset"], "robust");
    assert_eq!((&summary["seed"], &summary["episodes"]), (&SEED.into(), &EPISODES.into()));
    assert_eq!((&summary["steps"], first.episodes()), (&first.steps().into(), EPISODES as usize));
    for key in ["wall_s", "steps_per_s", "update_us"] {
        assert!(summary[key].as_f64().expect("a number") > 0.0, "{key}");
    }
    assert_eq!(summary["evaluation"]["episodes"], 5);
    let report = fs::read_to_string(out.join("report.html")).expect("report.html");
    assert!(report.contains("<svg") && report.contains("one_cylinder"));
    let events = fs::read_dir(out.join("tensorboard")).expect("tensorboard").count();
    assert_eq!(events, 1);
    assert!(out.join("checkpoint.safetensors").exists());
    assert!(out.join("figures/paths.svg").exists());

    // config.yaml holds the parameters of both nodes and reproduces the run with the same
    // simulator, whose layout is no longer fixed for the figures.
    let config = fs::read_to_string(out.join("config.yaml")).expect("config.yaml");
    for line in ["/**/agent_node:", "/**/sim_node:", "epsilon_min: 0.2", "heading_deviation:"] {
        assert!(config.contains(line), "{line} is missing from\n{config}");
    }
    let kept = nodes.path("config.yaml");
    fs::write(&kept, &config).expect("a copy");
    nodes.start_agent_with_file("train", &kept);
    nodes.succeed("agent_node", TRAINING);
    Outcome::read_from(&out).assert_identical(&first);
    // The first run was not overwritten.
    Outcome::read_from(&nodes.path("run.1")).assert_identical(&first);
}

#[test]
fn a_killed_and_restarted_simulator_does_not_change_the_result() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    start_simulator(&mut nodes);
    start_agent(&mut nodes, &out, "three_moving", &[]);
    for _ in 0..3 {
        nodes.wait_for_steps(40);
        nodes.kill("sim_node");
        start_simulator(&mut nodes);
    }
    nodes.succeed("agent_node", TRAINING);
    let log = nodes.log("agent_node");
    assert!(log.contains("the simulator was restarted: replaying"), "{log}");
    Outcome::read_from(&out).assert_identical(&in_process("three_moving", 1, &nodes.path("here")));
}

/// The background thread that writes a checkpoint and the final save write the same files.
#[test]
fn an_interruption_waits_for_the_checkpoint_that_is_being_written() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&["max_steps:=20"]);
    let directory = nodes.path("run");
    let out = format!("out:='{}'", directory.display());
    for round in 0..12 {
        let resume = format!("resume:={}", round > 0);
        let parameters = ["preset:=paper", "episodes:=100000", "checkpoint_interval:=1"];
        let parameters = [&parameters[..], &["evaluation_episodes:=0", &out, &resume]].concat();
        nodes.start_agent("train", &parameters);
        let checkpoint = directory.join("checkpoint.safetensors");
        let written = || fs::metadata(&checkpoint).and_then(|file| file.modified()).ok();
        let (before, end) = (written(), Instant::now() + TIMEOUT);
        while written() == before {
            assert!(Instant::now() < end, "{}", nodes.log("agent_node"));
            std::thread::sleep(Duration::from_millis(1));
        }
        // At a different moment of the next checkpoints in each round.
        std::thread::sleep(Duration::from_micros(700 * round));
        nodes.signal("agent_node", "INT");
        nodes.succeed("agent_node", TIMEOUT);
        let log = nodes.log("agent_node");
        assert!(!log.contains("could not write"), "round {round}: {log}");
    }
}

#[test]
fn resumed_training_has_the_undisturbed_result() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    start_simulator(&mut nodes);
    start_agent(&mut nodes, &out, "one_moving", &[]);
    for signal in ["INT", "TERM", "INT"] {
        nodes.wait_for_steps(60);
        nodes.signal("agent_node", signal);
        nodes.succeed("agent_node", TRAINING);
        start_agent(&mut nodes, &out, "one_moving", &["resume:=true"]);
    }
    nodes.succeed("agent_node", TRAINING);
    Outcome::read_from(&out).assert_identical(&in_process("one_moving", 1, &nodes.path("here")));
}

#[test]
fn an_agent_whose_episode_is_replaced_stops_with_an_error() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    start_simulator(&mut nodes);
    start_agent(&mut nodes, &out, "empty", &["episodes:=100000"]);
    nodes.wait_for_steps(20);
    let mut node = nodes.client();
    let reset = node.create_client::<evac_msgs::Reset>("reset").expect("a client");
    // A reset between two episodes replaces none, so it is repeated until it hits a running one.
    let end = Instant::now() + TIMEOUT;
    for request in 1.. {
        let request = evac_msgs::reset::Request { request, seed: 1, scenario: String::new() };
        node.block_on(reset.call(request, Some(TIMEOUT))).expect("a response");
        std::thread::sleep(Duration::from_millis(50));
        if nodes.ended("agent_node").is_some() {
            break;
        }
        assert!(Instant::now() < end, "{}", nodes.log("agent_node"));
    }
    let status = nodes.wait("agent_node", TIMEOUT);
    assert_eq!(status.code(), Some(1));
    let log = nodes.log("agent_node");
    assert!(log.contains("another client has taken over the environment"), "{log}");
    assert!(out.join("checkpoint.safetensors").exists(), "no checkpoint was saved");
}

#[test]
fn both_nodes_exit_promptly_on_sigint_and_sigterm() {
    for signal in ["INT", "TERM"] {
        let mut nodes = Nodes::new();
        let out = nodes.path("run");
        start_simulator(&mut nodes);
        start_agent(&mut nodes, &out, "empty", &["episodes:=100000"]);
        nodes.wait_for_steps(20);
        // The nodes need less than 2 s; the timeout allows for a loaded machine.
        for name in ["agent_node", "sim_node"] {
            nodes.signal(name, signal);
            nodes.succeed(name, Duration::from_secs(20));
        }
        // The same applies to an agent that is waiting for a simulator.
        let other = nodes.path("other");
        start_agent(&mut nodes, &other, "empty", &[]);
        nodes.wait_for_log("agent_node", "waiting for the service");
        nodes.signal("agent_node", signal);
        nodes.succeed("agent_node", Duration::from_secs(20));
    }
}

#[test]
fn a_pair_in_a_namespace_trains_and_its_config_is_complete() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    let names = ["-r", "__ns:=/robot1"];
    // Another simulator in the same domain, which the agent must not use.
    nodes.start_simulator(&["max_steps:=3"]);
    nodes.start_beside(
        "sim_node",
        "room",
        &[&["--ros-args"], &names[..], &["-r", "__node:=room"]].concat(),
    );
    let out_parameter = format!("out:='{}'", out.display());
    let mut arguments = vec!["train", "--ros-args"];
    arguments.extend(names);
    for parameter in [
        "episodes:=2",
        "epsilon_min:=1.0",
        "evaluation_episodes:=0",
        "simulator:=room",
        &out_parameter,
    ] {
        arguments.extend(["-p", parameter]);
    }
    nodes.start_beside("agent_node", "agent_node", &arguments);
    nodes.succeed("agent_node", TRAINING);
    assert!(nodes.log("room").contains("[robot1.room]: simulator ready"));
    let config = fs::read_to_string(out.join("config.yaml")).expect("config.yaml");
    for line in ["/**/agent_node:", "/**/sim_node:", "heading_deviation:", "max_steps: 10000"] {
        assert!(config.contains(line), "{line} is missing from\n{config}");
    }
}
