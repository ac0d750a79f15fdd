//! The two nodes on two hosts, and a network between them that loses, repeats, delays and reorders.
//!
//! These tests need a corrected build, root, Linux's TAP devices, util-linux and iproute2.

use std::{path::Path, time::Duration};

use evac_tests::{
    Nodes, Outcome, PATIENCE,
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
    assert!(is_corrected(), "RustDDS is uncorrected: run launch_scripts/setup.sh and build again");
    Network::is_possible().expect("a network of our own");
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
        "evaluation_episodes:=0".to_owned(),
    ];
    let parameters = parameters.each_ref().map(String::as_str);
    nodes.start_agent_on(here, "agent_node", "train", &parameters);
}

/// What the same training leaves where nothing is lost, and how many steps it takes.
fn undisturbed(nodes: &Nodes, episodes: u32) -> Outcome {
    let plan = Plan { scenario: "empty".to_owned(), episodes, seed: SEED, rooms: 1 };
    Outcome::in_process(plan, Preset::Paper, MAX_STEPS, &nodes.path("here"))
}

/// Trains over such a network; the result must be that of the undisturbed training, to the bit.
fn assert_trains_over(faults: Faults, episodes: u32, least_steps: u64) {
    let network = network(faults);
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    train(&mut nodes, &network, &out, episodes);
    nodes.succeed("agent_node", TRAINING);
    let outcome = Outcome::left_in(&out);
    outcome.assert_is(&undisturbed(&nodes, episodes));
    assert!(outcome.steps() >= least_steps, "{}", outcome.steps());
    println!("{faults:?}: {} steps, {:?}", outcome.steps(), network.traffic());
}

const DELAY: Duration = Duration::from_millis(5);

#[test]
fn one_packet_in_a_hundred_is_lost() {
    assert_trains_over(Faults { loss: 0.01, repetition: 0.2, delay: DELAY }, 100, 3000);
}

#[test]
fn one_packet_in_ten_is_lost() {
    assert_trains_over(Faults { loss: 0.1, repetition: 0.2, delay: DELAY }, 100, 3000);
}

#[test]
fn three_packets_in_ten_are_lost() {
    assert_trains_over(Faults { loss: 0.3, repetition: 0.2, delay: DELAY }, 100, 3000);
}

#[test]
fn each_packet_is_delayed_by_up_to_a_fifth_of_a_second() {
    let delay = Duration::from_millis(200);
    assert_trains_over(Faults { loss: 0.0, repetition: 0.1, delay }, 12, 500);
}

#[test]
fn a_training_goes_on_after_ten_seconds_without_a_network() {
    const EPISODES: u32 = 100;
    let network = network(Faults::default());
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    train(&mut nodes, &network, &out, EPISODES);
    // It is made when the training begins.
    nodes.wait_until("agent_node", || out.join("tensorboard").exists());
    for _ in 0..2 {
        network.set_cut(true);
        std::thread::sleep(Duration::from_secs(10));
        // There is no other way between the two, and there was something left to do.
        assert!(!out.join("summary.json").exists(), "the training is over already");
        network.set_cut(false);
        std::thread::sleep(Duration::from_millis(200));
    }
    nodes.succeed("agent_node", TRAINING);
    Outcome::left_in(&out).assert_is(&undisturbed(&nodes, EPISODES));
}

#[test]
fn an_answer_that_takes_several_packets_comes() {
    let network = network(Faults::default());
    let mut nodes = Nodes::new();
    let [here, there] = network.hosts();
    let out = format!("out:='{}'", nodes.path("run").display());
    nodes.start_agent_on(here, "agent_node", "train", &[&out]);
    let door = there.door().expect("the host is there");
    let discovery = Discovery { range: Range::Subnet, ..nodes.discovery(Security::Off) };
    // On the other host, so not in this thread.
    let reader = std::thread::spawn(move || {
        door.enter().expect("it is ours");
        let mut node = Node::with_discovery(
            "reader",
            &Arguments::default(),
            evac_msgs::DEFINITIONS,
            discovery,
        );
        let node = node.as_mut().expect("a node");
        let agent = ParameterClient::new(node, "/agent_node").expect("a client");
        // Twice: what follows such an answer comes, too.
        (0..2)
            .map(|_| node.block_on(agent.values(PATIENCE)).expect("an answer"))
            .collect::<Vec<_>>()
    });
    for values in reader.join().expect("it reads") {
        // Each takes 48 bytes at least, and a packet 1,500 at most.
        assert!(48 * values.len() > 1500, "{values:?}");
        assert_eq!(values.get("preset"), Some(&ParameterValue::String("robust".to_owned())));
    }
}

#[test]
fn a_policy_drives_although_a_fifth_of_the_packets_is_lost() {
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
    let escaped = log.lines().filter(|line| line.contains("the robot escaped")).count();
    assert!(escaped + 1 >= EPISODES, "{log}");
    nodes.signal("driver", "INT");
    nodes.succeed("driver", PATIENCE);
}
