//! Deployment: a trained policy drives a robot by nothing but images, whatever the robot does.

use std::{
    fs,
    path::PathBuf,
    time::{Duration, Instant},
};

use evac_msgs::{ActionCommand, EpisodeStatus};
use evac_tests::{Nodes, PATIENCE};
use ros_interfaces::{
    builtin_interfaces::Time,
    diagnostic_msgs::{DiagnosticArray, DiagnosticStatus},
    sensor_msgs::Image,
};
use ros_runtime::node::{Node, Subscription, reliable};

const TRAINING: Duration = Duration::from_secs(600);
/// A robot that is faster than most, so that the test is.
const ROBOT: [&str; 4] =
    ["frame_rate:=50", "motion_time:=0.02", "auto_reset:=true", "max_steps:=100"];
const SETTLE_TIME: &str = "settle_time:=0.06";
const EPISODES: usize = 20;

/// A model that was trained for a while, and its success in the test.
fn train(nodes: &mut Nodes) -> (PathBuf, f64) {
    let out = nodes.path("run");
    nodes.start_simulator(&[]);
    let parameters = [
        format!("out:='{}'", out.display()),
        "episodes:=400".to_owned(),
        "evaluation_episodes:=200".to_owned(),
        "figures:=false".to_owned(),
    ];
    let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
    nodes.start_agent("train", &parameters);
    nodes.succeed("agent_node", TRAINING);
    nodes.signal("sim_node", "INT");
    nodes.succeed("sim_node", PATIENCE);
    let summary = fs::read(out.join("summary.json")).expect("summary.json");
    let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
    (out, summary["evaluation"]["success_rate"].as_f64().expect("a number"))
}

fn next<M: ros_interfaces::RosMessage>(node: &Node, topic: &Subscription<M>) -> M {
    let next = node.block_on(async { tokio::time::timeout(PATIENCE, topic.async_take()).await });
    next.expect("a message in time").expect("a message that can be read").0
}

fn nanoseconds(stamp: Time) -> i64 {
    i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec)
}

/// Watches until so many episodes are over; how many of them were escapes.
fn watch(node: &Node, episodes: &Subscription<EpisodeStatus>, count: usize) -> usize {
    let (mut over, mut escaped) = (0, 0);
    while over < count {
        let status = next(node, episodes);
        over += usize::from(status.terminated || status.truncated);
        escaped += usize::from(status.terminated);
    }
    escaped
}

#[test]
fn a_policy_drives_by_images_alone_and_survives_what_happens_to_the_robot() {
    let mut nodes = Nodes::new();
    let (model, success_rate) = train(&mut nodes);
    assert!(success_rate > 0.95, "{success_rate}");
    let node = nodes.client();
    let episodes = node.create_subscription::<EpisodeStatus>("episode", reliable(100)).unwrap();
    let commands = node.create_subscription::<ActionCommand>("action", reliable(100)).unwrap();

    // The agent waits for its robot.
    nodes.start_agent("drive", &[&format!("model:='{}'", model.display()), SETTLE_TIME]);
    nodes.wait_for_log("agent_node", "waiting for images");
    nodes.start_simulator(&ROBOT);

    // What is executed answers an image of after the last move: by the stamps of both topics.
    let (mut over, mut escaped, mut settled) = (0, 0, i64::MAX);
    let mut given: Vec<ActionCommand> = Vec::new();
    while over < EPISODES {
        let status = next(&node, &episodes);
        let now = nanoseconds(status.header.stamp);
        // The first status may be of a step that was made before anybody listened.
        if status.step > 0 && settled < i64::MAX {
            let answers = |command: &ActionCommand| {
                let stamp = nanoseconds(command.header.stamp);
                command.action == status.action && (settled..now).contains(&stamp)
            };
            // The command may come after its effect: they are two topics.
            while !given.iter().any(answers) {
                let command = next(&node, &commands);
                assert!(!command.sent_by_service);
                let stamp = nanoseconds(command.header.stamp);
                assert!(stamp < now, "{status:?} answers nothing after {settled}: {given:?}");
                given.push(command);
            }
        }
        settled = now;
        given.retain(|command| nanoseconds(command.header.stamp) >= settled);
        over += usize::from(status.terminated || status.truncated);
        escaped += usize::from(status.terminated);
    }
    assert!(escaped + 2 >= EPISODES, "{escaped} of {EPISODES}: {}", nodes.log("sim_node"));

    // A robot that is lost: the agent says so where somebody looks, and drives nowhere.
    let reports =
        node.create_subscription::<DiagnosticArray>("/diagnostics", reliable(10)).unwrap();
    nodes.kill("sim_node");
    nodes.wait_for_log("agent_node", "no new image");
    let end = Instant::now() + PATIENCE;
    let driver = loop {
        assert!(Instant::now() < end, "the driver never reports that it waits");
        let mut parts = next(&node, &reports).status.into_iter();
        let driver = parts.find(|part| part.name == "agent_node: driver");
        if let Some(driver) = driver.filter(|driver| driver.level != DiagnosticStatus::OK) {
            break driver;
        }
    };
    assert_eq!(driver.level, DiagnosticStatus::WARN);
    assert!(driver.message.starts_with("waiting for images"), "{}", driver.message);
    while let Ok(Some(_)) = commands.take() {}

    // Images of another camera are not answered, either.
    let mut other = nodes.client();
    let publisher = other.create_publisher::<Image>("camera/image", reliable(1)).unwrap();
    let large = Image { width: 640, height: 480, encoding: "bgr8".into(), ..Image::default() };
    let end = Instant::now() + PATIENCE;
    while !nodes.log("agent_node").contains("640 x 480") {
        assert!(Instant::now() < end, "{}", nodes.log("agent_node"));
        publisher.publish_with(|| large.clone());
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(commands.take().expect("commands can be read").is_none());

    // Another one in its place, whose clock begins anew.
    nodes.start_simulator(&ROBOT);
    let escaped = watch(&node, &episodes, EPISODES / 2);
    assert!(escaped + 2 >= EPISODES / 2, "{escaped}: {}", nodes.log("sim_node"));
    nodes.signal("agent_node", "INT");
    nodes.succeed("agent_node", PATIENCE);
}
