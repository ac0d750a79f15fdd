//! Trainings by the real nodes: the same to the byte however they are run, stopped or disturbed.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

use evac_msgs::{ActionCommand, EpisodeStatus, QValues, TrainingStatus};
use evac_tests::{Nodes, Outcome, PATIENCE};
use learning::{settings::Preset, training::Plan};
use ros_interfaces::builtin_interfaces::Time;
use ros_runtime::{
    node::reliable,
    parameters::{ParameterClient, ParameterValue},
};

/// Long enough for some hundred steps on any machine.
const TRAINING: Duration = Duration::from_secs(300);
/// Rooms where nobody searches for ever, so that a test need not.
const MAX_STEPS: u32 = 60;
const EPISODES: u32 = 12;
const SEED: u64 = 5;

/// The same training in this process.
fn in_process(scenario: &str, rooms: usize, directory: &Path) -> Outcome {
    in_process_by(Preset::default(), scenario, rooms, directory)
}

fn in_process_by(preset: Preset, scenario: &str, rooms: usize, directory: &Path) -> Outcome {
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
fn over_dds_and_in_one_process_are_the_same_to_the_byte() {
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
        let here = in_process_by(preset, scenario, 1, &nodes.path("here"));
        Outcome::left_in(&out).assert_is(&here);
    }
}

#[test]
fn several_simulators_at_once_give_one_result_too() {
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
    Outcome::left_in(&out).assert_is(&here);
}

/// The simulator has them already, and is sent none; whoever else listens gets them all.
#[test]
fn actions_are_published_for_whoever_watches() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    start_simulator(&mut nodes);
    let watcher = nodes.client();
    let actions = watcher.create_subscription::<ActionCommand>("action", reliable(1000));
    let actions = actions.expect("a subscription");
    let statuses = watcher.create_subscription::<EpisodeStatus>("episode", reliable(1000));
    let statuses = statuses.expect("a subscription");
    let thoughts = watcher.create_subscription::<QValues>("q_values", reliable(1000));
    let thoughts = thoughts.expect("a subscription");
    // The other preset leaves out what has been tried from the same image.
    start_agent(&mut nodes, &out, "empty", &["preset:=paper"]);
    watcher.block_on(async {
        let patience = Duration::from_secs(60);
        // From some moment on the watcher is known; then every step has its command, in order.
        for _ in 0..50 {
            let next = tokio::time::timeout(patience, actions.async_take()).await;
            let (command, _) = next.expect("a command").expect("a readable one");
            assert!(command.sent_by_service);
            loop {
                let next = tokio::time::timeout(patience, statuses.async_take()).await;
                let (status, _) = next.expect("a status").expect("a readable one");
                // The command answers the image before.
                if status.step > 0 && status.header.stamp > command.header.stamp {
                    assert_eq!(status.action, command.action);
                    break;
                }
            }
        }
        // Why it does what it does: the best action, unless it explores.
        for _ in 0..50 {
            let next = tokio::time::timeout(patience, thoughts.async_take()).await;
            let (thought, _) = next.expect("values").expect("readable ones");
            let best = thought.values.iter().copied().fold(f32::MIN, f32::max);
            let chosen = thought.values[usize::from(thought.action)];
            assert!(thought.explored || chosen == best, "{thought:?}");
        }
    });
    nodes.succeed("agent_node", TRAINING);
}

/// `use_sim_time`, and what becomes of it while the node runs.
#[test]
fn the_agent_goes_by_the_clock_that_it_is_told_to() {
    // Of the simulator's clock, which begins at 0, no test sees so much; the wall's was there long ago.
    const LONG_AGO_S: i32 = 1_000_000_000;
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
            let next = tokio::time::timeout(PATIENCE, statuses.async_take()).await;
            next.expect("a status").expect("a readable one").0.header.stamp
        };
        let mut latest = next_stamp().await;
        for _ in 0..20 {
            let stamp = next_stamp().await;
            assert!(stamp.sec < LONG_AGO_S && stamp >= latest, "{stamp:?} after {latest:?}");
            latest = stamp;
        }
        assert!(latest > Time::default());
        for (use_sim_time, expected) in [(false, "the wall's"), (true, "the simulator's")] {
            let value = ParameterValue::Bool(use_sim_time);
            let set = parameters.set("use_sim_time", value, PATIENCE).await;
            assert_eq!(set, Ok(Ok(())));
            let end = Instant::now() + PATIENCE;
            while (next_stamp().await.sec < LONG_AGO_S) != use_sim_time {
                assert!(Instant::now() < end, "the time is never {expected}");
            }
        }
    });
}

#[test]
fn a_run_leaves_its_files_and_its_config_repeats_it() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    // The agent first: it waits.
    start_agent(&mut nodes, &out, "one_cylinder", &["epsilon_min:=0.2"]);
    nodes.wait_for_log("agent_node", "waiting for the service /reset");
    start_simulator(&mut nodes);
    nodes.succeed("agent_node", TRAINING);
    let first = Outcome::left_in(&out);

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

    // config.yaml holds what both nodes were run with: it is enough to run them again, in the same
    // simulator, which nothing holds fixed any more.
    let config = fs::read_to_string(out.join("config.yaml")).expect("config.yaml");
    for line in ["/**/agent_node:", "/**/sim_node:", "epsilon_min: 0.2", "heading_deviation:"] {
        assert!(config.contains(line), "{line} is missing in\n{config}");
    }
    let kept = nodes.path("config.yaml");
    fs::write(&kept, &config).expect("a copy");
    nodes.start_agent_with_file("train", &kept);
    nodes.succeed("agent_node", TRAINING);
    Outcome::left_in(&out).assert_is(&first);
    // The first run was not overwritten.
    Outcome::left_in(&nodes.path("run.1")).assert_is(&first);
}

#[test]
fn a_simulator_that_is_killed_and_started_again_changes_nothing() {
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
    assert!(log.contains("the simulator was restarted: repeating"), "{log}");
    Outcome::left_in(&out).assert_is(&in_process("three_moving", 1, &nodes.path("here")));
}

#[test]
fn a_training_that_is_stopped_goes_on_as_if_it_had_not_been() {
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
    Outcome::left_in(&out).assert_is(&in_process("one_moving", 1, &nodes.path("here")));
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
    // A reset between two episodes replaces none: so again, until one comes in the midst.
    let end = Instant::now() + PATIENCE;
    for request in 1.. {
        let request = evac_msgs::reset::Request { request, seed: 1, scenario: String::new() };
        node.block_on(reset.call(request, Some(PATIENCE))).expect("an answer");
        std::thread::sleep(Duration::from_millis(50));
        if nodes.ended("agent_node").is_some() {
            break;
        }
        assert!(Instant::now() < end, "{}", nodes.log("agent_node"));
    }
    let status = nodes.wait("agent_node", PATIENCE);
    assert_eq!(status.code(), Some(1));
    let log = nodes.log("agent_node");
    assert!(log.contains("another client has taken over the simulator"), "{log}");
    assert!(out.join("checkpoint.safetensors").exists(), "what was learnt is saved");
}

#[test]
fn both_nodes_end_at_once_when_they_are_told_to() {
    for signal in ["INT", "TERM"] {
        let mut nodes = Nodes::new();
        let out = nodes.path("run");
        start_simulator(&mut nodes);
        start_agent(&mut nodes, &out, "empty", &["episodes:=100000"]);
        nodes.wait_for_steps(20);
        // Two seconds are promised; a loaded machine gets more before this test calls it hanging.
        for name in ["agent_node", "sim_node"] {
            nodes.signal(name, signal);
            nodes.succeed(name, Duration::from_secs(20));
        }
        // The agent alone, waiting for a simulator that is not there.
        let other = nodes.path("other");
        start_agent(&mut nodes, &other, "empty", &[]);
        nodes.wait_for_log("agent_node", "waiting for the service");
        nodes.signal("agent_node", signal);
        nodes.succeed("agent_node", Duration::from_secs(20));
    }
}

#[test]
fn a_pair_in_a_namespace_meets_there_and_its_config_is_complete() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    let names = ["-r", "__ns:=/robot1"];
    // Another room in the same domain, which must stay out of it.
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
    assert!(nodes.log("room").contains("[robot1.room]: the room is open"));
    let config = fs::read_to_string(out.join("config.yaml")).expect("config.yaml");
    for line in ["/**/agent_node:", "/**/sim_node:", "heading_deviation:", "max_steps: 10000"] {
        assert!(config.contains(line), "{line} is missing in\n{config}");
    }
}
