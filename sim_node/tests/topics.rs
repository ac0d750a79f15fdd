//! What the node publishes, as a reader in another process hears it over loopback.

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

/// What is not there after this time never comes; a bound for hanging, not a measure of speed.
const PATIENCE: Duration = Duration::from_secs(60);

/// In this time a message that is on its way arrives, and a reader's leave is noticed.
const A_WHILE: Duration = Duration::from_secs(1);

/// The simulator as a process, a node that watches it, and clients of its services.
struct Room {
    simulator: Child,
    watcher: Node,
    resets: ServiceClient<Reset>,
    steps: ServiceClient<Step>,
    discovery: Discovery,
}

impl Room {
    fn new(parameters: &[&str]) -> Self {
        // From 102 on, the ports of RTPS lie where Linux takes those of outgoing connections.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = std::process::id() * 11 + COUNT.fetch_add(1, Ordering::Relaxed);
        let domain_id = 1 + (number % 101) as u16;
        let simulator = Command::new(env!("CARGO_BIN_EXE_sim_node"))
            .arg("--ros-args")
            .args(parameters.iter().flat_map(|parameter| ["-p", parameter]))
            .env("ROS_DOMAIN_ID", domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .stdin(Stdio::null())
            .spawn()
            .expect("the simulator starts");
        let discovery = Discovery { domain_id, range: Range::Localhost, security: Security::Off };
        let arguments = Arguments::default();
        let mut watcher =
            Node::with_discovery("watcher", &arguments, evac_msgs::DEFINITIONS, discovery.clone())
                .expect("a node");
        let resets = watcher.create_client("reset").expect("a client");
        let steps = watcher.create_client("step").expect("a client");
        Self { simulator, watcher, resets, steps, discovery }
    }

    /// Another node that watches.
    fn newcomer(&self) -> Node {
        Node::with_discovery(
            "newcomer",
            &Arguments::default(),
            evac_msgs::DEFINITIONS,
            self.discovery.clone(),
        )
        .expect("a node")
    }

    fn reset(&self, request: u64) -> reset::Response {
        let request = reset::Request { request, seed: 7, scenario: String::new() };
        self.watcher.block_on(self.resets.call(request, Some(PATIENCE))).expect("an answer")
    }

    /// Steps ahead: the stamp of the image.
    fn step(&self, episode: u64, number: u32) -> Time {
        let request = step::Request { episode, step: number, action: 3 };
        let answer =
            self.watcher.block_on(self.steps.call(request, Some(PATIENCE))).expect("an answer");
        assert_eq!(answer.status, status::OK, "{}", answer.message);
        answer.image.header.stamp
    }

    fn wait(&self) {
        std::thread::sleep(A_WHILE);
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        let _ = self.simulator.kill();
        let _ = self.simulator.wait();
    }
}

/// A reader of a topic.
struct Reader<M: 'static>(Subscription<M>);

impl<M: RosMessage + DeserializeOwned + Debug> Reader<M> {
    /// Of what is said from now on.
    fn new(node: &mut Node, topic: &str) -> Self {
        Self(node.create_subscription(topic, reliable(100)).expect("a subscription"))
    }

    /// Of what was said before, too. It takes a new node: what one reader of a participant has
    /// received, RustDDS gives to later ones of the same participant.
    fn of_latched(node: &mut Node, topic: &str) -> Self {
        Self(node.create_subscription(topic, latched(100)).expect("a subscription"))
    }

    fn next(&self, room: &Room) -> M {
        let next = async { timeout(PATIENCE, self.0.async_take()).await };
        let next = room.watcher.block_on(next);
        next.expect("a message comes").expect("it can be read").0
    }

    /// The message with this stamp, past those from before.
    fn stamped(&self, room: &Room, stamp: Time, stamp_of: impl Fn(&M) -> Time) -> M {
        loop {
            let message = self.next(room);
            assert!(stamp_of(&message) <= stamp, "{stamp:?} never came: {message:?}");
            if stamp_of(&message) == stamp {
                return message;
            }
        }
    }

    /// What has come that was not read yet.
    fn rest(&self) -> Vec<M> {
        std::iter::from_fn(|| self.0.take().expect("it can be read"))
            .map(|(message, _)| message)
            .collect()
    }
}

fn drawn_at(scene: &MarkerArray) -> Time {
    scene.markers[0].header.stamp
}

#[test]
fn whoever_comes_late_gets_the_present_scene_and_none_before() {
    let room = Room::new(&["scenario:=concave", "fixed_robot:=[0.0, -0.3, 0.0]"]);
    let mut first_node = room.newcomer();
    let mount = Reader::<TFMessage>::of_latched(&mut first_node, "tf_static").next(&room);
    let children: Vec<&str> =
        mount.transforms.iter().map(|link| link.child_frame_id.as_str()).collect();
    assert_eq!(children, ["camera_link", "camera_optical_frame"]);

    let episode = room.reset(1).episode;
    room.step(episode, 1);
    let now = room.step(episode, 2);
    let early = Reader::<MarkerArray>::of_latched(&mut first_node, "scene");
    assert_eq!(drawn_at(&early.next(&room)), now);
    for number in 3..50 {
        room.step(episode, number);
    }
    let now = room.step(episode, 50);
    early.stamped(&room, now, drawn_at);
    room.wait();
    assert!(early.rest().is_empty());
    drop(early);
    room.wait();

    // Nobody has seen these.
    room.step(episode, 51);
    let now = room.step(episode, 52);
    let (mut second_node, mut third_node) = (room.newcomer(), room.newcomer());
    let late = Reader::<MarkerArray>::of_latched(&mut second_node, "scene");
    assert_eq!(drawn_at(&late.next(&room)), now);
    let another = Reader::<MarkerArray>::of_latched(&mut third_node, "scene");
    assert_eq!(drawn_at(&another.next(&room)), now);
    room.wait();
    assert!(late.rest().iter().chain(&another.rest()).all(|scene| drawn_at(scene) == now));
}

#[test]
fn every_step_is_published_with_the_stamp_of_its_image() {
    let mut room = Room::new(&["fixed_robot:=[0.0, 0.0, 0.0]", "fixed_exit:=[2.0, 0.0]"]);
    let images = Reader::<Image>::new(&mut room.watcher, "camera/image");
    let camera_infos = Reader::<CameraInfo>::new(&mut room.watcher, "camera/camera_info");
    let clock = Reader::<Clock>::new(&mut room.watcher, "clock");
    let transforms = Reader::<TFMessage>::new(&mut room.watcher, "tf");
    let odometry = Reader::<Odometry>::new(&mut room.watcher, "odom");
    let paths = Reader::<Path>::new(&mut room.watcher, "path");
    let episode = room.reset(1).episode;
    // The simulator has found these readers when it hears a client of theirs.
    room.wait();
    for number in 1..=5 {
        let stamp = room.step(episode, number);
        let x = 0.1524 * f64::from(number);
        let near = |actual: f64| assert!((actual - x).abs() < 1e-12, "step {number}: {actual}");
        let image = images.stamped(&room, stamp, |image| image.header.stamp);
        let camera_info = camera_infos.stamped(&room, stamp, |info| info.header.stamp);
        assert_eq!(camera_info.header, image.header);
        clock.stamped(&room, stamp, |clock| clock.clock);
        let robot = transforms.stamped(&room, stamp, |robot| robot.transforms[0].header.stamp);
        near(robot.transforms[0].transform.translation.x);
        let odometry = odometry.stamped(&room, stamp, |odometry| odometry.header.stamp);
        near(odometry.pose.pose.position.x);
        let path = paths.stamped(&room, stamp, |path| path.header.stamp);
        assert_eq!(path.poses.len(), number as usize + 1);
        near(path.poses[number as usize].pose.position.x);
    }
    // Everything else is executed once and said once.
    room.wait();
    assert!(clock.rest().is_empty() && images.rest().is_empty());
}

#[test]
fn what_is_fixed_can_be_changed_between_two_episodes() {
    let mut room = Room::new(&[]);
    let odometry = Reader::<Odometry>::new(&mut room.watcher, "odom");
    let parameters = ParameterClient::new(&mut room.watcher, "sim_node").unwrap();
    let set = |room: &Room, name: &str, numbers: &[f64]| {
        let value = ParameterValue::DoubleArray(numbers.to_vec());
        room.watcher.block_on(parameters.set(name, value, PATIENCE)).unwrap()
    };
    let before = room.reset(1);
    room.wait();
    assert!(set(&room, "fixed_robot", &[0.5]).unwrap_err().contains("it is [x, y, yaw]"));
    assert!(set(&room, "fixed_exit", &[0.0, 1.5]).unwrap_err().contains("within ±1 m"));

    assert_eq!(set(&room, "fixed_robot", &[1.2, 0.0, 0.0]), Ok(()));
    let refused = room.reset(2);
    assert_eq!((refused.status, refused.episode), (status::INVALID_SCENARIO, before.episode));
    assert!(refused.message.contains("touches a wall"), "{}", refused.message);

    assert_eq!(set(&room, "fixed_robot", &[0.5, -0.25, 0.0]), Ok(()));
    let placed = room.reset(3);
    assert_eq!(placed.status, status::OK, "{}", placed.message);
    let stamp = placed.image.header.stamp;
    let position =
        odometry.stamped(&room, stamp, |odometry| odometry.header.stamp).pose.pose.position;
    assert_eq!((position.x, position.y), (0.5, -0.25));
}
