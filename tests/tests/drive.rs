//! Deployment: a trained policy drives a robot using only images and survives robot failures.

use std::{
    fs,
    path::PathBuf,
    time::{Duration, Instant},
};

use evac_msgs::{ActionCommand, EpisodeStatus};
use evac_tests::{Nodes, TIMEOUT};
use ros_interfaces::{
    builtin_interfaces::Time,
    diagnostic_msgs::{DiagnosticArray, DiagnosticStatus},
    sensor_msgs::Image,
};
use ros_runtime::node::{Node, Subscription, reliable};

const TRAINING: Duration = Duration::from_secs(600);
/// Makes the simulator act as a robot in real time, with fast moves to keep the test short.
const ROBOT: [&str; 4] =
    ["frame_rate:=50", "motion_time:=0.02", "auto_reset:=true", "max_steps:=100"];
const SETTLE_TIME: &str = "settle_time:=0.06";
const EPISODES: usize = 20;

/// Trains a model for 400 episodes. Returns its directory and the success rate of its evaluation.
fn train(nodes: &mut Nodes) -> (PathBuf, f64) {
    let out = nodes.path("run");
    nodes.start_simulator(&[]);
    let parameters = [
        format!("out:='{}'", out.display()),
        "scenario:=empty".to_owned(),
        "episodes:=400".to_owned(),
        "evaluation_episodes:=200".to_owned(),
        "figures:=false".to_owned(),
    ];
    let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
    nodes.start_agent("train", &parameters);
    nodes.succeed("agent_node", TRAINING);
    nodes.signal("sim_node", "INT");
    nodes.succeed("sim_node", TIMEOUT);
    let summary = fs::read(out.join("summary.json")).expect("summary.json");
    let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
    (out, summary["evaluation"]["success_rate"].as_f64().expect("a number"))
}

fn next<M: ros_interfaces::RosMessage>(node: &Node, topic: &Subscription<M>) -> M {
    let next = node.block_on(async { tokio::time::timeout(TIMEOUT, topic.async_take()).await });
    next.expect("a message before the timeout").expect("a valid message").0
}

fn nanoseconds(stamp: Time) -> i64 {
    i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec)
}

/// Waits for the end of `count` episodes and returns how many of them succeeded.
fn count_successes(node: &Node, episodes: &Subscription<EpisodeStatus>, count: usize) -> usize {
    let (mut finished, mut succeeded) = (0, 0);
    while finished < count {
        let status = next(node, episodes);
        finished += usize::from(status.terminated || status.truncated);
        succeeded += usize::from(status.terminated);
    }
    succeeded
}

#[test]
fn a_policy_drives_using_only_images_and_survives_robot_failures() {
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

    // Every executed command must be based on an image taken after the previous move. A command
    // carries the stamp of its image, which is compared with the stamps on /episode.
    let (mut finished, mut succeeded, mut previous_move) = (0, 0, i64::MAX);
    let mut received: Vec<ActionCommand> = Vec::new();
    while finished < EPISODES {
        let status = next(&node, &episodes);
        let now = nanoseconds(status.header.stamp);
        // Skips the first status: its command may predate our subscription.
        if status.step > 0 && previous_move < i64::MAX {
            let is_cause = |command: &ActionCommand| {
                let stamp = nanoseconds(command.header.stamp);
                command.action == status.action && (previous_move..now).contains(&stamp)
            };
            // The topics are independent: the status may arrive before its command.
            while !received.iter().any(is_cause) {
                let command = next(&node, &commands);
                assert!(!command.sent_by_service);
                let stamp = nanoseconds(command.header.stamp);
                assert!(
                    stamp < now,
                    "no command since {previous_move} explains {status:?}: {received:?}"
                );
                received.push(command);
            }
        }
        previous_move = now;
        received.retain(|command| nanoseconds(command.header.stamp) >= previous_move);
        finished += usize::from(status.terminated || status.truncated);
        succeeded += usize::from(status.terminated);
    }
    assert!(succeeded + 2 >= EPISODES, "{succeeded} of {EPISODES}: {}", nodes.log("sim_node"));

    // The robot fails: the agent reports it on /diagnostics and sends no more commands.
    let reports =
        node.create_subscription::<DiagnosticArray>("/diagnostics", reliable(10)).unwrap();
    nodes.kill("sim_node");
    nodes.wait_for_log("agent_node", "no new image");
    let end = Instant::now() + TIMEOUT;
    let driver = loop {
        assert!(Instant::now() < end, "the driver does not report that it is waiting");
        let mut statuses = next(&node, &reports).status.into_iter();
        let driver = statuses.find(|status| status.name == "agent_node: driver");
        if let Some(driver) = driver.filter(|driver| driver.level != DiagnosticStatus::OK) {
            break driver;
        }
    };
    assert_eq!(driver.level, DiagnosticStatus::WARN);
    assert!(driver.message.starts_with("waiting for images"), "{}", driver.message);
    while let Ok(Some(_)) = commands.take() {}

    // Images of the wrong size are ignored, too.
    let mut other = nodes.client();
    let publisher = other.create_publisher::<Image>("camera/image", reliable(1)).unwrap();
    let large = Image { width: 640, height: 480, encoding: "bgr8".into(), ..Image::default() };
    let end = Instant::now() + TIMEOUT;
    while !nodes.log("agent_node").contains("640 x 480") {
        assert!(Instant::now() < end, "{}", nodes.log("agent_node"));
        publisher.publish_with(|| large.clone());
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(commands.take().expect("valid commands").is_none());

    // A new robot takes over, whose clock starts again at 0.
    nodes.start_simulator(&ROBOT);
    let succeeded = count_successes(&node, &episodes, EPISODES / 2);
    assert!(succeeded + 2 >= EPISODES / 2, "{succeeded}: {}", nodes.log("sim_node"));
    nodes.signal("agent_node", "INT");
    nodes.succeed("agent_node", TIMEOUT);
}
