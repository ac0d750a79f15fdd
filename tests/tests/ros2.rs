//! What a user types beside the nodes on a machine with ROS 2.
//!
//! These tests need a sourced ROS 2 Jazzy and a sourced workspace with the packages of this repository:
//! `EVAC_ROS2=required launch_scripts/test.sh --all` runs them.

use std::{
    fs,
    io::Write,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use evac_msgs::{ActionCommand, EpisodeStatus};
use evac_tests::{Nodes, PATIENCE, repository};
use ros_interfaces::{RosMessage, geometry_msgs::Twist, sensor_msgs::Image, std_msgs::Header};
use ros_runtime::node::{Node, Subscription, reliable};
use tokio::time::timeout;

/// Images come by themselves, and a stock tool has something to hear.
const SIMULATOR: [&str; 1] = ["frame_rate:=20.0"];

/// `ros2` with some words after it, in the domain of the nodes.
fn ros2(nodes: &Nodes, words: &str) -> Command {
    let mut command = nodes.command("ros2");
    command.args(words.split(' '));
    command
}

/// What `ros2` prints, which must come to an end well.
fn output(nodes: &Nodes, command: &mut Command) -> String {
    let (status, text, error) = nodes.run(command);
    assert!(status.success(), "{command:?}: {text}\n{error}");
    text
}

/// Repeats a command until it prints what is expected: a new process hears of the nodes by and by.
fn output_with(nodes: &Nodes, words: &str, expected: &[&str]) -> String {
    let end = Instant::now() + PATIENCE;
    loop {
        let (_, text, error) = nodes.run(&mut ros2(nodes, words));
        // What is refused is told on standard error.
        let text = text + &error;
        match expected.iter().find(|part| !text.contains(**part)) {
            None => return text,
            Some(part) => {
                assert!(Instant::now() < end, "`ros2 {words}` never prints '{part}': {text}");
            }
        }
    }
}

/// A simulator that publishes images by itself.
fn simulator() -> Nodes {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&SIMULATOR);
    nodes
}

/// Beside it an agent that trains.
fn training() -> Nodes {
    let mut nodes = simulator();
    let out = format!("out:='{}'", nodes.path("run").display());
    nodes.start_agent("train", &["episodes:=100000", &out]);
    nodes
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn topics_are_listed_heard_and_described() {
    let nodes = training();
    let topics = [
        "/camera/image [sensor_msgs/msg/Image]",
        "/camera/camera_info [sensor_msgs/msg/CameraInfo]",
        "/clock [rosgraph_msgs/msg/Clock]",
        "/odom [nav_msgs/msg/Odometry]",
        "/tf [tf2_msgs/msg/TFMessage]",
        "/tf_static [tf2_msgs/msg/TFMessage]",
        "/scene [visualization_msgs/msg/MarkerArray]",
        "/path [nav_msgs/msg/Path]",
        "/diagnostics [diagnostic_msgs/msg/DiagnosticArray]",
        "/episode [evac_msgs/msg/EpisodeStatus]",
        "/action [evac_msgs/msg/ActionCommand]",
        "/training_status [evac_msgs/msg/TrainingStatus]",
        "/rosout [rcl_interfaces/msg/Log]",
        "/parameter_events [rcl_interfaces/msg/ParameterEvent]",
    ];
    output_with(&nodes, "topic list --no-daemon --show-types", &topics);
    let image = output_with(
        &nodes,
        "topic echo --no-daemon --once /camera/image sensor_msgs/msg/Image",
        &["encoding: rgb8", "width: 20", "height: 7", "frame_id: camera_optical_frame"],
    );
    assert!(image.contains("step: 60"), "{image}");
    output_with(
        &nodes,
        "topic info --no-daemon --verbose /camera/image",
        &["Node name: sim_node", "Reliability: RELIABLE", "Durability: VOLATILE"],
    );
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn rviz_is_set_up_for_topics_that_are_published() {
    let nodes = simulator();
    let file = repository().join("launch_scripts/rviz/evac.rviz");
    let settings = std::fs::read_to_string(file).expect("the configuration of RViz");
    let values = settings.lines().filter_map(|line| line.trim().strip_prefix("Value: "));
    let topics: Vec<&str> = values.filter(|value| value.starts_with('/')).collect();
    assert!(topics.contains(&"/camera/image") && topics.contains(&"/scene"), "{topics:?}");
    output_with(&nodes, "topic list --no-daemon", &topics);
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn the_rate_of_the_images_is_measured() {
    let nodes = simulator();
    // It has no end of its own.
    let log = nodes.path("rate");
    let mut hz = ros2(&nodes, "topic hz /camera/image")
        .env("PYTHONUNBUFFERED", "1")
        .stdout(std::fs::File::create(&log).expect("a file"))
        .stderr(Stdio::null())
        .spawn()
        .expect("ros2 starts");
    let end = Instant::now() + PATIENCE;
    let is_measured = loop {
        let text = std::fs::read_to_string(&log).unwrap_or_default();
        if text.contains("average rate: ") || Instant::now() > end {
            break text.contains("average rate: ");
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    hz.kill().expect("it is our child");
    hz.wait().expect("it is our child");
    assert!(is_measured);
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn node_info_lists_what_is_there() {
    let nodes = training();
    let info = output_with(
        &nodes,
        "node info --no-daemon /sim_node",
        &["/reset: evac_msgs/srv/Reset", "/step: evac_msgs/srv/Step", "/camera/image"],
    );
    let section = |title: &str| -> Vec<String> {
        let lines = info.lines().skip_while(|line| line.trim() != title).skip(1);
        let lines = lines.take_while(|line| line.starts_with("    "));
        lines.map(|line| line.trim().to_owned()).collect()
    };
    let expected = [
        ("Subscribers:", &["/action: evac_msgs/msg/ActionCommand"][..]),
        (
            "Publishers:",
            &[
                "/camera/camera_info: sensor_msgs/msg/CameraInfo",
                "/camera/image: sensor_msgs/msg/Image",
                "/clock: rosgraph_msgs/msg/Clock",
                "/diagnostics: diagnostic_msgs/msg/DiagnosticArray",
                "/episode: evac_msgs/msg/EpisodeStatus",
                "/odom: nav_msgs/msg/Odometry",
                "/parameter_events: rcl_interfaces/msg/ParameterEvent",
                "/path: nav_msgs/msg/Path",
                "/rosout: rcl_interfaces/msg/Log",
                "/scene: visualization_msgs/msg/MarkerArray",
                "/tf: tf2_msgs/msg/TFMessage",
                "/tf_static: tf2_msgs/msg/TFMessage",
            ],
        ),
        (
            "Service Servers:",
            &[
                "/reset: evac_msgs/srv/Reset",
                "/sim_node/describe_parameters: rcl_interfaces/srv/DescribeParameters",
                "/sim_node/get_parameter_types: rcl_interfaces/srv/GetParameterTypes",
                "/sim_node/get_parameters: rcl_interfaces/srv/GetParameters",
                "/sim_node/get_type_description: type_description_interfaces/srv/GetTypeDescription",
                "/sim_node/list_parameters: rcl_interfaces/srv/ListParameters",
                "/sim_node/set_parameters: rcl_interfaces/srv/SetParameters",
                "/sim_node/set_parameters_atomically: rcl_interfaces/srv/SetParametersAtomically",
                "/step: evac_msgs/srv/Step",
            ],
        ),
        ("Service Clients:", &[]),
    ];
    for (title, entries) in expected {
        assert_eq!(section(title), entries, "{title} in {info}");
    }
    let agent = output_with(
        &nodes,
        "node info --no-daemon /agent_node",
        &["/reset: evac_msgs/srv/Reset", "/training_status: evac_msgs/msg/TrainingStatus"],
    );
    assert!(agent.contains("/sim_node/get_parameters"), "{agent}");
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn parameters_are_listed_described_and_set() {
    let nodes = simulator();
    output_with(&nodes, "param list --no-daemon /sim_node", &["scenario", "max_steps"]);
    output_with(&nodes, "param get --no-daemon /sim_node scenario", &["String value is: empty"]);
    output_with(
        &nodes,
        "param describe --no-daemon /sim_node scenario",
        &["Type: string", "one of: empty, one_cylinder"],
    );
    output_with(
        &nodes,
        "param set --no-daemon /sim_node scenario concave",
        &["Set parameter successful"],
    );
    output_with(&nodes, "param get --no-daemon /sim_node scenario", &["String value is: concave"]);
    let refused = output_with(
        &nodes,
        "param set --no-daemon /sim_node scenario desert",
        &["expected one of empty"],
    );
    assert!(!refused.contains("successful"), "{refused}");
    output_with(&nodes, "param dump --no-daemon /sim_node", &["/sim_node:", "scenario: concave"]);
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn services_are_called() {
    let nodes = simulator();
    let call = |nodes: &Nodes, words: &str, request: &str| {
        output(nodes, ros2(nodes, &format!("service call {words}")).arg(request))
    };
    let begun = call(&nodes, "/reset evac_msgs/srv/Reset", "{seed: 7, scenario: concave}");
    assert!(begun.contains("success=True"), "{begun}");
    let taken = call(&nodes, "/step evac_msgs/srv/Step", "{action: 3}");
    assert!(taken.contains("success=True") && taken.contains("step=1"), "{taken}");
    let refused = call(&nodes, "/step evac_msgs/srv/Step", "{action: 9}");
    assert!(refused.contains("success=False") && refused.contains("0 to 6"), "{refused}");
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn a_training_is_recorded_and_played_again() {
    let mut nodes = training();
    let bag = nodes.path("bag");
    let bag = bag.to_str().expect("a path in Unicode");
    let mut recorder = ros2(&nodes, "bag record --output")
        .args([bag, "/camera/image", "/odom"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("ros2 starts");
    // What it has heard is known from its end only.
    std::thread::sleep(Duration::from_secs(5));
    interrupt(&recorder);
    assert!(recorder.wait().expect("it is our child").success());
    nodes.kill("agent_node");
    nodes.kill("sim_node");
    let info = output(&nodes, ros2(&nodes, "bag info").arg(bag));
    assert!(info.contains("Topic: /camera/image | Type: sensor_msgs/msg/Image"), "{info}");
    let mut player = ros2(&nodes, "bag play --loop")
        .arg(bag)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("ros2 starts");
    output_with(
        &nodes,
        "topic echo --no-daemon --once /camera/image sensor_msgs/msg/Image",
        &["encoding: rgb8", "width: 20"],
    );
    interrupt(&player);
    player.wait().expect("it is our child");
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn the_pair_is_launched() {
    let nodes = Nodes::new();
    for file in ["train.launch.py", "train.launch.xml"] {
        let out = nodes.path(file);
        let file = repository().join("launch_scripts/launch").join(file);
        let file = file.to_str().expect("a path in Unicode");
        let mut launch = ros2(&nodes, "launch");
        launch.args([file, "scenario:=concave", "episodes:=5", "seed:=3"]);
        launch.arg(format!("out:={}", out.display()));
        let text = output(&nodes, &mut launch);
        assert!(out.join("summary.json").exists(), "{text}");
    }
}

/// The agent that the `evac` of a launch has started, once there is one that is none of `others`.
fn launched_agent(launch: &Child, others: &[String]) -> String {
    let end = Instant::now() + PATIENCE;
    loop {
        for evac in children("evac", &launch.id().to_string()) {
            let mut agents = children("agent_node", &evac).into_iter();
            if let Some(agent) = agents.find(|agent| !others.contains(agent)) {
                return agent;
            }
        }
        assert!(Instant::now() < end, "no agent is launched");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// The processes with this name that another one has started.
fn children(name: &str, parent: &str) -> Vec<String> {
    let processes = fs::read_dir("/proc").expect("there are processes");
    // Its number, its name in brackets, its state, and whose child it is.
    let found = processes.flatten().filter_map(|process| {
        let text = fs::read_to_string(process.path().join("stat")).ok()?;
        let (id, rest) = text.split_once(&format!(" ({name}) "))?;
        (rest.split(' ').nth(1) == Some(parent)).then(|| id.to_owned())
    });
    found.collect()
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn a_launched_agent_that_fails_goes_on_with_its_training() {
    let nodes = Nodes::new();
    let out = nodes.path("run");
    let file = repository().join("launch_scripts/launch/train.launch.xml");
    let mut launch = ros2(&nodes, "launch")
        .arg(file)
        .args(["episodes:=1000", "preset:=paper", "evaluation_episodes:=5"])
        .arg(format!("out:={}", out.display()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("ros2 starts");
    let mut agents = Vec::new();
    for _ in 0..2 {
        agents.push(launched_agent(&launch, &agents));
        let checkpoint = out.join("checkpoint.safetensors");
        let before = fs::metadata(&checkpoint).and_then(|file| file.modified()).ok();
        let end = Instant::now() + PATIENCE;
        while fs::metadata(&checkpoint).and_then(|file| file.modified()).ok() == before {
            assert!(Instant::now() < end, "there is no other checkpoint");
            std::thread::sleep(Duration::from_millis(20));
        }
        let agent = agents.last().expect("there is one");
        let status = Command::new("kill").args(["-ABRT", agent]).status();
        assert!(status.expect("a signal").success());
    }
    assert!(launch.wait().expect("it is our child").success());
    let episodes = fs::read_to_string(out.join("episodes.csv")).expect("episodes");
    assert_eq!(episodes.lines().count(), 1001);
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn a_trained_model_is_launched_to_drive() {
    let mut nodes = Nodes::new();
    let model = nodes.path("run");
    let out = format!("out:='{}'", model.display());
    nodes.start_simulator(&[]);
    nodes.start_agent("train", &["episodes:=5", "evaluation_episodes:=0", &out]);
    nodes.succeed("agent_node", PATIENCE);
    nodes.kill("sim_node");
    let watcher = nodes.client();
    let statuses = watcher.create_subscription("episode", reliable(100)).expect("a subscription");
    let mut launch = ros2(&nodes, "launch evac_bringup drive.launch.py")
        .arg(format!("model:={}", model.display()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("ros2 starts");
    wait_for(&watcher, &statuses, |status: &EpisodeStatus| status.step >= 3);
    interrupt(&launch);
    launch.wait().expect("it is our child");
}

/// One of the examples in rclpy, as a program.
fn example(nodes: &Nodes, name: &str) -> Command {
    let mut command = nodes.command("python3");
    command.arg(repository().join("launch_scripts/examples").join(name));
    command
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn the_room_is_stepped_by_hand() {
    let nodes = simulator();
    let text = output(&nodes, &mut example(&nodes, "room.py"));
    assert!(text.contains("step 1: action "), "{text}");
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn the_keys_drive_the_robot() {
    let nodes = simulator();
    let watcher = nodes.client();
    let statuses = watcher.create_subscription("episode", reliable(100)).expect("a subscription");
    // It wants a terminal, which `script` is to it; that takes a line for a shell, as which a command
    // is shown.
    let program = format!("{:?}", example(&nodes, "teleoperation.py"));
    let mut teleoperation = nodes
        .command("script")
        .args(["--quiet", "--return", "--command", &program, "/dev/null"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("script starts");
    let mut keys = teleoperation.stdin.take().expect("it is piped");
    let mut press = |key: &str| {
        keys.write_all(key.as_bytes()).and_then(|()| keys.flush()).expect("somebody reads");
    };
    // Who drives is not there at once, and a key is not pressed twice by itself.
    let end = Instant::now() + PATIENCE;
    for (key, action) in [("\x1b[A", 3), ("\x1b[D", 4), ("d", 1)] {
        loop {
            press(key);
            let next = async { timeout(Duration::from_secs(1), statuses.async_take()).await };
            let status = watcher.block_on(next).map(|status| status.expect("a readable one").0);
            if status.is_ok_and(|status: EpisodeStatus| status.action == action) {
                break;
            }
            assert!(Instant::now() < end, "the key for action {action} does nothing");
        }
    }
    press("q");
    assert!(teleoperation.wait().expect("it is our child").success());
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn the_bridge_shrinks_images_and_moves_the_robot() {
    let nodes = simulator();
    // The simulator's camera is the robot's: its small images are those that the bridge makes of them.
    let mut bridge = example(&nodes, "robot_bridge.py")
        .args(["--ros-args", "-p", "use_sim_time:=true"])
        .args(["-r", "image:=/camera/image", "-r", "camera_info:=/camera/camera_info"])
        .args(["-r", "camera/image:=/small/image", "-r", "action:=/small/action"])
        .stderr(Stdio::null())
        .spawn()
        .expect("python3 starts");
    let mut watcher = nodes.client();
    let large = watcher.create_subscription("camera/image", reliable(100)).expect("a subscription");
    let small = watcher.create_subscription("small/image", reliable(100)).expect("a subscription");
    let actions = watcher.create_publisher("small/action", reliable(1)).expect("a publisher");
    let shrunk: Image = wait_for(&watcher, &small, |_| true);
    let original: Image =
        wait_for(&watcher, &large, |image: &Image| image.header.stamp >= shrunk.header.stamp);
    assert_eq!(shrunk.data, original.data, "the room stands still");
    let velocities = watcher.create_subscription::<Twist>("cmd_vel", reliable(100));
    let velocities = velocities.expect("a subscription");
    let end = Instant::now() + PATIENCE;
    // It says nothing to a robot that is to stand still.
    while velocities.take().expect("a readable message").is_none() {
        assert!(Instant::now() < end, "the bridge never moves the robot");
        let image: Image = wait_for(&watcher, &small, |_| true);
        let header = Header { stamp: image.header.stamp, ..Header::default() };
        actions.publish_with(|| ActionCommand { header, action: 5, sent_by_service: false });
    }
    interrupt(&bridge);
    bridge.wait().expect("it is our child");
}

/// The next message that is as it should be.
fn wait_for<M: RosMessage>(
    node: &Node,
    subscription: &Subscription<M>,
    is_wanted: impl Fn(&M) -> bool,
) -> M {
    let found = async {
        loop {
            let (message, _) = subscription.async_take().await.expect("a readable message");
            if is_wanted(&message) {
                return message;
            }
        }
    };
    node.block_on(async { timeout(PATIENCE, found).await }).expect("a message in time")
}

/// Ctrl-C, for what ends by it.
fn interrupt(child: &std::process::Child) {
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(status.expect("kill can be called").success());
}
