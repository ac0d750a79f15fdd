//! Tests of the published topics, with subscribers in another process over loopback.

use std::{
    fmt::Debug,
    process::{Child, Command, Stdio},
    sync::atomic::{AtomicU32, Ordering},
    time::Duration,
};

use evac_msgs::{Reset, Step, reset, status, step};
use ros_interfaces::{
    RosMessage,
    builtin_interfaces::Time,
    nav_msgs::{Odometry, Path},
    rosgraph_msgs::Clock,
    sensor_msgs::CameraInfo,
    sensor_msgs::Image,
    tf2_msgs::TFMessage,
    visualization_msgs::MarkerArray,
};
use ros_runtime::{
    Arguments, Node,
    discovery::{Discovery, Range},
    node::{Subscription, latched, reliable},
    parameters::{ParameterClient, ParameterValue},
    security::Security,
    service::ServiceClient,
};
use serde::de::DeserializeOwned;
use tokio::time::timeout;

/// Timeout for each wait. It only stops a test that hangs and is not a performance requirement.
const TIMEOUT: Duration = Duration::from_secs(60);

/// Time for messages in transit to arrive and for endpoints to be matched or unmatched.
const SETTLE_TIME: Duration = Duration::from_secs(1);

/// A running `sim_node` process, and a node in the process of the test with clients for its services.
struct Simulator {
    process: Child,
    node: Node,
    resets: ServiceClient<Reset>,
    steps: ServiceClient<Step>,
    discovery: Discovery,
}

impl Simulator {
    fn new(parameters: &[&str]) -> Self {
        // From domain 102 onwards, RTPS ports are in Linux's ephemeral port range.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = std::process::id() * 11 + COUNT.fetch_add(1, Ordering::Relaxed);
        let domain_id = 1 + (number % 101) as u16;
        let process = Command::new(env!("CARGO_BIN_EXE_sim_node"))
            .arg("--ros-args")
            .args(parameters.iter().flat_map(|parameter| ["-p", parameter]))
            .env("ROS_DOMAIN_ID", domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .stdin(Stdio::null())
            .spawn()
            .expect("the simulator starts");
        let discovery = Discovery { domain_id, range: Range::Localhost, security: Security::Off };
        let arguments = Arguments::default();
        let mut node =
            Node::with_discovery("client", &arguments, evac_msgs::DEFINITIONS, discovery.clone())
                .expect("a node");
        let resets = node.create_client("reset").expect("a client");
        let steps = node.create_client("step").expect("a client");
        Self { process, node, resets, steps, discovery }
    }

    /// Creates another node in the same domain.
    fn new_node(&self) -> Node {
        Node::with_discovery(
            "subscriber",
            &Arguments::default(),
            evac_msgs::DEFINITIONS,
            self.discovery.clone(),
        )
        .expect("a node")
    }

    fn reset(&self, request: u64) -> reset::Response {
        let request = reset::Request { request, seed: 7, scenario: String::new() };
        self.node.block_on(self.resets.call(request, Some(TIMEOUT))).expect("a response")
    }

    /// Executes a step straight ahead. Returns the stamp of its image.
    fn step(&self, episode: u64, number: u32) -> Time {
        let request = step::Request { episode, step: number, action: 3 };
        let response =
            self.node.block_on(self.steps.call(request, Some(TIMEOUT))).expect("a response");
        assert_eq!(response.status, status::OK, "{}", response.message);
        response.image.header.stamp
    }

    fn wait(&self) {
        std::thread::sleep(SETTLE_TIME);
    }
}

impl Drop for Simulator {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A subscriber to a topic.
struct Subscriber<M: 'static>(Subscription<M>);

impl<M: RosMessage + DeserializeOwned + Debug> Subscriber<M> {
    /// Subscribes to future messages.
    fn new(node: &mut Node, topic: &str) -> Self {
        Self(node.create_subscription(topic, reliable(100)).expect("a subscription"))
    }

    /// Subscribes to a latched topic.
    ///
    /// To test a late subscriber, pass a new node: if a participant already has a subscriber to the
    /// topic, RustDDS also delivers previously received messages to the new subscriber.
    fn latched(node: &mut Node, topic: &str) -> Self {
        Self(node.create_subscription(topic, latched(100)).expect("a subscription"))
    }

    fn next(&self, simulator: &Simulator) -> M {
        let next = async { timeout(TIMEOUT, self.0.async_take()).await };
        let next = simulator.node.block_on(next);
        next.expect("a message before the timeout").expect("a valid message").0
    }

    /// Returns the message with this stamp; discards earlier ones.
    fn stamped(&self, simulator: &Simulator, stamp: Time, stamp_of: impl Fn(&M) -> Time) -> M {
        loop {
            let message = self.next(simulator);
            assert!(stamp_of(&message) <= stamp, "no message with stamp {stamp:?}: {message:?}");
            if stamp_of(&message) == stamp {
                return message;
            }
        }
    }

    /// Returns the received messages that have not been taken yet.
    fn remaining(&self) -> Vec<M> {
        std::iter::from_fn(|| self.0.take().expect("a valid message"))
            .map(|(message, _)| message)
            .collect()
    }
}

fn scene_stamp(scene: &MarkerArray) -> Time {
    scene.markers[0].header.stamp
}

#[test]
fn a_late_subscriber_receives_the_current_scene_and_no_earlier_one() {
    let simulator = Simulator::new(&["scenario:=concave", "fixed_robot:=[0.0, -0.3, 0.0]"]);
    let mut first_node = simulator.new_node();
    let mount = Subscriber::<TFMessage>::latched(&mut first_node, "tf_static").next(&simulator);
    let children: Vec<&str> =
        mount.transforms.iter().map(|link| link.child_frame_id.as_str()).collect();
    assert_eq!(children, ["camera_link", "camera_optical_frame"]);

    let episode = simulator.reset(1).episode;
    simulator.step(episode, 1);
    let now = simulator.step(episode, 2);
    let early = Subscriber::<MarkerArray>::latched(&mut first_node, "scene");
    assert_eq!(scene_stamp(&early.next(&simulator)), now);
    for number in 3..50 {
        simulator.step(episode, number);
    }
    let now = simulator.step(episode, 50);
    early.stamped(&simulator, now, scene_stamp);
    simulator.wait();
    assert!(early.remaining().is_empty());
    drop(early);
    simulator.wait();

    // These scenes are produced while there is no subscriber.
    simulator.step(episode, 51);
    let now = simulator.step(episode, 52);
    let (mut second_node, mut third_node) = (simulator.new_node(), simulator.new_node());
    let late = Subscriber::<MarkerArray>::latched(&mut second_node, "scene");
    assert_eq!(scene_stamp(&late.next(&simulator)), now);
    let another = Subscriber::<MarkerArray>::latched(&mut third_node, "scene");
    assert_eq!(scene_stamp(&another.next(&simulator)), now);
    simulator.wait();
    let (late, another) = (late.remaining(), another.remaining());
    assert!(late.iter().chain(&another).all(|scene| scene_stamp(scene) == now));
}

#[test]
fn every_step_is_published_with_the_stamp_of_its_image() {
    let mut simulator = Simulator::new(&["fixed_robot:=[0.0, 0.0, 0.0]", "fixed_exit:=[2.0, 0.0]"]);
    let images = Subscriber::<Image>::new(&mut simulator.node, "camera/image");
    let camera_infos = Subscriber::<CameraInfo>::new(&mut simulator.node, "camera/camera_info");
    let clock = Subscriber::<Clock>::new(&mut simulator.node, "clock");
    let transforms = Subscriber::<TFMessage>::new(&mut simulator.node, "tf");
    let odometry = Subscriber::<Odometry>::new(&mut simulator.node, "odom");
    let paths = Subscriber::<Path>::new(&mut simulator.node, "path");
    let episode = simulator.reset(1).episode;
    // The response shows that the simulator has discovered this node. Wait until it has also
    // discovered the subscribers.
    simulator.wait();
    for number in 1..=5 {
        let stamp = simulator.step(episode, number);
        let x = 0.1524 * f64::from(number);
        let near = |actual: f64| assert!((actual - x).abs() < 1e-12, "step {number}: {actual}");
        let image = images.stamped(&simulator, stamp, |image| image.header.stamp);
        let camera_info = camera_infos.stamped(&simulator, stamp, |info| info.header.stamp);
        assert_eq!(camera_info.header, image.header);
        clock.stamped(&simulator, stamp, |clock| clock.clock);
        let robot = transforms.stamped(&simulator, stamp, |robot| robot.transforms[0].header.stamp);
        near(robot.transforms[0].transform.translation.x);
        let odometry = odometry.stamped(&simulator, stamp, |odometry| odometry.header.stamp);
        near(odometry.pose.pose.position.x);
        let path = paths.stamped(&simulator, stamp, |path| path.header.stamp);
        assert_eq!(path.poses.len(), number as usize + 1);
        near(path.poses[number as usize].pose.position.x);
    }
    // Each step is published once.
    simulator.wait();
    assert!(clock.remaining().is_empty() && images.remaining().is_empty());
}

#[test]
fn the_fixed_layout_can_be_changed_between_episodes() {
    let mut simulator = Simulator::new(&[]);
    let odometry = Subscriber::<Odometry>::new(&mut simulator.node, "odom");
    let parameters = ParameterClient::new(&mut simulator.node, "sim_node").unwrap();
    let set = |simulator: &Simulator, name: &str, numbers: &[f64]| {
        let value = ParameterValue::DoubleArray(numbers.to_vec());
        simulator.node.block_on(parameters.set(name, value, TIMEOUT)).unwrap()
    };
    let before = simulator.reset(1);
    simulator.wait();
    assert!(set(&simulator, "fixed_robot", &[0.5]).unwrap_err().contains("expected: [x, y, yaw]"));
    assert!(set(&simulator, "fixed_exit", &[0.0, 1.5]).unwrap_err().contains("within ±1 m"));

    assert_eq!(set(&simulator, "fixed_robot", &[1.2, 0.0, 0.0]), Ok(()));
    let refused = simulator.reset(2);
    assert_eq!((refused.status, refused.episode), (status::INVALID_SCENARIO, before.episode));
    assert!(refused.message.contains("touches a wall"), "{}", refused.message);

    assert_eq!(set(&simulator, "fixed_robot", &[0.5, -0.25, 0.0]), Ok(()));
    let placed = simulator.reset(3);
    assert_eq!(placed.status, status::OK, "{}", placed.message);
    let stamp = placed.image.header.stamp;
    let position =
        odometry.stamped(&simulator, stamp, |odometry| odometry.header.stamp).pose.pose.position;
    assert_eq!((position.x, position.y), (0.5, -0.25));
}
