//! Perturbations of the simulator, set and observed over DDS.

use std::{path::Path, time::Duration};

use evac_msgs::{Reset, reset, status};
use evac_tests::{Nodes, Outcome, TIMEOUT};
use learning::{settings::Preset, training::Plan};
use ros_interfaces::{
    builtin_interfaces::Time, diagnostic_msgs::DiagnosticArray, rosgraph_msgs::Clock,
    sensor_msgs::Image,
};
use ros_runtime::{
    node::{Node, Subscription, reliable},
    parameters::{ParameterClient, ParameterValue},
};
use sim_node::{
    reality::{Randomization, Reality},
    world::WorldSettings,
};
use task::RobustnessRow;

/// Timeout of a training run; ample for its few hundred steps.
const TRAINING: Duration = Duration::from_secs(300);
/// Keeps the episodes of an untrained agent short.
const MAX_STEPS: u32 = 60;

fn next<M: ros_interfaces::RosMessage>(node: &Node, topic: &Subscription<M>) -> M {
    let next = node.block_on(async { tokio::time::timeout(TIMEOUT, topic.async_take()).await });
    next.expect("a message arrives before the timeout").expect("the message is valid").0
}

#[test]
fn training_with_randomization_gives_the_same_result_despite_killed_simulators() {
    let mut nodes = Nodes::new();
    let out = nodes.path("run");
    let max_steps = format!("max_steps:={MAX_STEPS}");
    let simulator = [max_steps.as_str(), "randomization:=strong"];
    nodes.start_simulator(&simulator);
    let plan = Plan { scenario: "three_moving".to_owned(), episodes: 12, seed: 5, rooms: 1 };
    let arguments = [
        &format!("out:='{}'", out.display()),
        "scenario:=three_moving",
        "episodes:=12",
        "seed:=5",
        "evaluation_episodes:=3",
        "max_steps:=20",
    ];
    nodes.start_agent("train", &arguments);
    for _ in 0..2 {
        nodes.wait_for_steps(40);
        nodes.kill("sim_node");
        nodes.start_simulator(&simulator);
    }
    nodes.succeed("agent_node", TRAINING);
    let log = nodes.log("agent_node");
    assert!(log.contains("the simulator was restarted: replaying"), "{log}");
    let world = WorldSettings {
        max_steps: MAX_STEPS,
        reality: Reality::of(Randomization::Strong),
        ..WorldSettings::default()
    };
    let here =
        Outcome::with_settings(plan, Preset::default().settings(), world, &nodes.path("here"));
    Outcome::read_from(&out).assert_identical(&here);
    let config = std::fs::read_to_string(out.join("config.yaml")).expect("config.yaml exists");
    for line in ["randomization: strong", "camera.noise: 10.0", "motion.blocked: mixed"] {
        assert!(config.contains(line), "{line} is missing from\n{config}");
    }
}

#[test]
fn a_level_set_at_run_time_takes_effect_at_the_next_reset_and_is_reported() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&[]);
    let mut node = nodes.client();
    let resets = node.create_client::<Reset>("reset").expect("a client can be created");
    let parameters = ParameterClient::new(&mut node, "sim_node").expect("a client can be created");
    let reports = node
        .create_subscription::<DiagnosticArray>("/diagnostics", reliable(10))
        .expect("the topic can be subscribed to");
    let reset = |request| {
        let request = reset::Request { request, seed: 7, scenario: "concave".to_owned() };
        let response = node.block_on(resets.call(request, Some(TIMEOUT))).expect("a response");
        assert_eq!(response.status, status::OK, "{}", response.message);
        response.image.data
    };
    let set = |name, value| {
        node.block_on(parameters.set(name, value, TIMEOUT)).expect("the service responds")
    };
    let level = |name: &str| set("randomization", ParameterValue::String(name.to_owned()));
    let wait_for_report = |message: &str| loop {
        let report = next(&node, &reports);
        if report
            .status
            .iter()
            .any(|status| status.name.ends_with(": perturbations") && status.message == message)
        {
            break;
        }
    };
    let clean = reset(1);
    level("strong").expect("the level is valid");
    let strong = reset(2);
    assert_ne!(strong, clean);
    assert_eq!(reset(3), strong, "the perturbations depend only on the seed");
    wait_for_report("strong");
    set("camera.noise", ParameterValue::Double(1.0)).expect("the value is valid");
    assert_ne!(reset(4), strong);
    wait_for_report("custom");
    level("none").expect("the level is valid");
    assert_eq!(reset(5), clean, "without perturbations, the bytes are as before");
    let error = level("extreme").expect_err("an unknown level is refused");
    assert!(error.contains("expected one of none, mild, strong"), "{error}");
}

#[test]
fn the_robustness_of_a_policy_is_measured_and_the_simulator_is_left_as_it_was() {
    let mut nodes = Nodes::new();
    let (model, out) = (nodes.path("model"), nodes.path("out"));
    nodes.start_simulator(&["max_steps:=20", "camera.noise:=7"]);
    let model_directory = format!("out:='{}'", model.display());
    nodes.start_agent(
        "train",
        &[&model_directory, "episodes:=3", "evaluation_episodes:=0", "scenario:=one_moving"],
    );
    nodes.succeed("agent_node", TRAINING);
    let evaluate = |nodes: &mut Nodes, out: &Path| {
        let (model, out) =
            (format!("model:='{}'", model.display()), format!("out:='{}'", out.display()));
        let plan = ["episodes:=4", "max_steps:=12", "figures:=false", "robustness:=true"];
        nodes.start_agent("evaluate", &[&[&*model, &*out][..], &plan].concat());
    };
    evaluate(&mut nodes, &out);
    nodes.succeed("agent_node", TRAINING);
    let json = std::fs::read(out.join("robustness.json")).expect("robustness.json exists");

    // A simulator that is restarted lacks the perturbations that were set at run time.
    let again = nodes.path("again");
    evaluate(&mut nodes, &again);
    for evaluation in ["3 of 29", "12 of 29"] {
        nodes.wait_for_log("agent_node", &format!("evaluation {evaluation}"));
        nodes.kill("sim_node");
        nodes.start_simulator(&["max_steps:=20", "camera.noise:=7"]);
    }
    nodes.succeed("agent_node", TRAINING);
    let repeated = std::fs::read(again.join("robustness.json")).expect("robustness.json exists");
    assert_eq!(repeated, json);
    assert!(nodes.log("agent_node").contains("repeating the evaluation"));

    let rows: Vec<RobustnessRow> = serde_json::from_slice(&json).expect("the format is valid");
    let names: Vec<_> =
        rows.iter().map(|row| (row.perturbation.as_str(), row.level.as_str())).collect();
    assert_eq!(names.len(), 1 + 2 * 13 + 2);
    assert_eq!(
        names[..3],
        [("clean", "none"), ("camera.noise", "mild"), ("camera.noise", "strong")]
    );
    assert_eq!(names[27..], [("all", "mild"), ("all", "strong")]);
    // Each evaluation has the same episodes, and what does not affect them changes nothing.
    let result = |name: &str| {
        let row = rows.iter().find(|row| row.perturbation == name && row.level != "mild");
        let row = row.expect("the row exists");
        assert_eq!((row.scenario.as_str(), row.episodes), ("one_moving", 4));
        (row.success_rate, row.blocked_per_100_steps, row.mean_steps)
    };
    assert_eq!(result("camera.latency"), result("clean"));
    assert_eq!(result("odom.noise, odom.drift"), result("clean"));
    let csv = std::fs::read_to_string(out.join("robustness.csv")).expect("robustness.csv exists");
    assert_eq!(csv.lines().count(), 1 + rows.len());
    assert!(csv.starts_with("scenario,perturbation,level,episodes,success_rate,"), "{csv}");
    for file in ["robustness.html", "figures/robustness.svg"] {
        let text = std::fs::read_to_string(out.join(file)).expect("the file exists");
        assert!(text.contains("light and surfaces"), "{file}");
    }

    let mut node = nodes.client();
    let parameters = ParameterClient::new(&mut node, "sim_node").expect("a client can be created");
    let values = node.block_on(parameters.values(TIMEOUT)).expect("the service responds");
    assert_eq!(values["randomization"], ParameterValue::String("none".to_owned()));
    assert_eq!(values["camera.noise"], ParameterValue::Double(7.0));
    assert_eq!(values["motion.blocked"], ParameterValue::String("stay".to_owned()));
}

#[test]
fn images_in_real_time_are_delayed_lost_and_noisy() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&[
        "frame_rate:=50",
        "camera.noise:=5",
        "camera.latency:=0.3",
        "camera.drop_rate:=0.5",
    ]);
    let node = nodes.client();
    let images = node
        .create_subscription::<Image>("camera/image", reliable(100))
        .expect("the topic can be subscribed to");
    let clock = node
        .create_subscription::<Clock>("clock", reliable(100))
        .expect("the topic can be subscribed to");
    let nanoseconds = |stamp: Time| i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec);
    // All images that have been taken have a stamp on the clock.
    let (mut stamps, mut received) = (Vec::new(), Vec::new());
    while received.len() < 60 {
        let image = next(&node, &images);
        while let Some((message, _)) = clock.take().expect("the message is valid") {
            stamps.push(nanoseconds(message.clock));
        }
        // The clock is already past the exposure by the latency. This holds however late the image
        // is received, and however the two topics are scheduled, but for the first few images.
        let stamp = nanoseconds(image.header.stamp);
        let now = stamps.last().copied().unwrap_or_default();
        received.push((stamp, now - stamp, image.data));
    }
    let late = received.iter().filter(|(_, delay, _)| *delay >= 200_000_000).count();
    assert!(late >= 50, "only {late} of 60 images were delayed");
    assert!(received.windows(2).all(|pair| pair[0].0 < pair[1].0), "the order is kept");
    let different = received.windows(2).filter(|pair| pair[0].2 != pair[1].2).count();
    assert_eq!(different, 59, "each image has its own noise");
    let (first, last) = (received[0].0, received[59].0);
    let taken = stamps.iter().filter(|stamp| (first..=last).contains(stamp)).count();
    assert!((90..180).contains(&taken), "60 of {taken} images were received");
}
