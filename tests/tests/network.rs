//! The two nodes on two hosts, connected by a network that loses, duplicates, delays and reorders
//! packets.
//!
//! These tests need a corrected build, root, Linux's TAP devices, util-linux and iproute2.

use std::{path::Path, time::Duration};

use evac_tests::{
    Nodes, Outcome, TIMEOUT,
    network::{Faults, Network},
};
use learning::{settings::Preset, training::Plan};
use ros_runtime::{
    Arguments, Node,
    corrections::is_corrected,
    discovery::{Discovery, Range},
    parameters::{ParameterClient, ParameterValue},
    security::Security,
};

const TRAINING: Duration = Duration::from_secs(900);
const MAX_STEPS: u32 = 60;
const SEED: u64 = 5;

fn network(faults: Faults) -> Network {
    assert!(is_corrected(), "RustDDS is not patched: run launch_scripts/setup.sh and rebuild");
    Network::check_requirements().expect("an emulated network");
    Network::new(faults, 1).expect("two hosts")
}

fn train(nodes: &mut Nodes, network: &Network, out: &Path, episodes: u32) {
    let [here, there] = network.hosts();
    let max_steps = format!("max_steps:={MAX_STEPS}");
    nodes.start_simulator_on(there, "sim_node", &[&max_steps]);
    let parameters = [
        format!("out:='{}'", out.display()),
        format!("episodes:={episodes}"),
        format!("seed:={SEED}"),
        "preset:=paper".to_owned(),
        "scenario:=empty".to_owned(),
        "evaluation_episodes:=0".to_owned(),
    ];
    let parameters = parameters.each_ref().map(String::as_str);
    nodes.start_agent_on(here, "agent_node", "train", &parameters);
}

/// Returns the result of the same training run in this process.
fn undisturbed(nodes: &Nodes, episodes: u32) -> Outcome {
    let plan = Plan { scenario: "empty".to_owned(), episodes, seed: SEED, rooms: 1 };
    Outcome::in_process(plan, Preset::Paper, MAX_STEPS, &nodes.path("here"))
}

/// Trains over a network with these faults. Asserts that the result is bit-identical to that of an
/// undisturbed training run, and that the training took at least `min_steps` steps.
fn assert_trains_over(faults: Faults, episodes: u32, min_steps: u64) {
    let network = network(faults);
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    train(&mut nodes, &network, &out, episodes);
    nodes.succeed("agent_node", TRAINING);
    let outcome = Outcome::read_from(&out);
    outcome.assert_identical(&undisturbed(&nodes, episodes));
    assert!(outcome.steps() >= min_steps, "{}", outcome.steps());
    println!("{faults:?}: {} steps, {:?}", outcome.steps(), network.traffic());
}

const DELAY: Duration = Duration::from_millis(5);

#[test]
fn training_survives_1_percent_packet_loss() {
    assert_trains_over(Faults { loss: 0.01, repetition: 0.2, delay: DELAY }, 100, 3000);
}

#[test]
fn training_survives_10_percent_packet_loss() {
    assert_trains_over(Faults { loss: 0.1, repetition: 0.2, delay: DELAY }, 100, 3000);
}

#[test]
fn training_survives_30_percent_packet_loss() {
    assert_trains_over(Faults { loss: 0.3, repetition: 0.2, delay: DELAY }, 100, 3000);
}

#[test]
fn training_survives_delays_of_up_to_200_ms() {
    let delay = Duration::from_millis(200);
    assert_trains_over(Faults { loss: 0.0, repetition: 0.1, delay }, 12, 500);
}

#[test]
fn training_continues_after_ten_seconds_without_a_network() {
    const EPISODES: u32 = 100;
    let network = network(Faults::default());
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    train(&mut nodes, &network, &out, EPISODES);
    // The directory is created when the training begins.
    nodes.wait_until("agent_node", || out.join("tensorboard").exists());
    for _ in 0..2 {
        network.set_partitioned(true);
        std::thread::sleep(Duration::from_secs(10));
        // The training must not have finished while the network was down.
        assert!(!out.join("summary.json").exists(), "the training has already ended");
        network.set_partitioned(false);
        std::thread::sleep(Duration::from_millis(200));
    }
    nodes.succeed("agent_node", TRAINING);
    Outcome::read_from(&out).assert_identical(&undisturbed(&nodes, EPISODES));
}

#[test]
fn a_response_that_takes_several_packets_arrives() {
    let network = network(Faults::default());
    let mut nodes = Nodes::new();
    let [here, there] = network.hosts();
    let out = format!("out:='{}'", nodes.path("run").display());
    nodes.start_agent_on(here, "agent_node", "train", &[&out]);
    let namespace = there.door().expect("the host exists");
    let discovery = Discovery { range: Range::Subnet, ..nodes.discovery(Security::Off) };
    // A separate thread, because it moves to the other host permanently.
    let reader = std::thread::spawn(move || {
        namespace.enter().expect("permission to enter the namespace");
        let mut node = Node::with_discovery(
            "reader",
            &Arguments::default(),
            evac_msgs::DEFINITIONS,
            discovery,
        );
        let node = node.as_mut().expect("a node");
        let agent = ParameterClient::new(node, "/agent_node").expect("a client");
        // Twice, because later responses must arrive, too.
        (0..2)
            .map(|_| node.block_on(agent.values(TIMEOUT)).expect("a response"))
            .collect::<Vec<_>>()
    });
    for values in reader.join().expect("the reader does not panic") {
        // A value takes at least 48 bytes, and a packet at most 1,500.
        assert!(48 * values.len() > 1500, "{values:?}");
        assert_eq!(values.get("preset"), Some(&ParameterValue::String("robust".to_owned())));
    }
}

#[test]
fn a_policy_drives_with_20_percent_packet_loss() {
    const EPISODES: usize = 10;
    let faults = Faults { loss: 0.2, ..Faults::default() };
    let network = network(faults);
    let mut nodes = Nodes::new();
    let model = nodes.path("run");
    nodes.start_simulator(&[]);
    let out = format!("out:='{}'", model.display());
    nodes.start_agent("train", &[&out, "episodes:=400", "evaluation_episodes:=0"]);
    nodes.succeed("agent_node", TRAINING);
    nodes.kill("sim_node");

    let [here, there] = network.hosts();
    let robot = ["frame_rate:=50", "motion_time:=0.02", "auto_reset:=true", "max_steps:=100"];
    nodes.start_simulator_on(there, "robot", &robot);
    let model = format!("model:='{}'", model.display());
    nodes.start_agent_on(here, "driver", "drive", &[&model, "settle_time:=0.06"]);
    nodes.wait_for_log("robot", &format!("of {EPISODES} episodes so far"));
    let log = nodes.log("robot");
    let succeeded = log.lines().filter(|line| line.contains("the robot escaped")).count();
    assert!(succeeded + 1 >= EPISODES, "{log}");
    nodes.signal("driver", "INT");
    nodes.succeed("driver", TIMEOUT);
}
