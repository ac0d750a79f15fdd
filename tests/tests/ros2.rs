//! Uses the nodes with the ROS 2 command-line tools, the launch files and the examples.
//!
//! These tests need ROS 2 Jazzy and a workspace with the packages of this repository, both sourced:
//! `EVAC_ROS2=required launch_scripts/test.sh --all` runs them.

use std::{
    fs,
    io::Write,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use evac_msgs::{ActionCommand, EpisodeStatus};
use evac_tests::{Nodes, TIMEOUT, repository};
use ros_interfaces::{RosMessage, geometry_msgs::Twist, sensor_msgs::Image, std_msgs::Header};
use ros_runtime::node::{Node, Subscription, reliable};
use tokio::time::timeout;

/// Makes the simulator publish images without any request, so that the tools have something to
/// receive.
const SIMULATOR: [&str; 1] = ["frame_rate:=20.0"];

/// Returns a `ros2` command in the domain of the nodes.
fn ros2(nodes: &Nodes, arguments: &str) -> Command {
    let mut command = nodes.command("ros2");
    command.args(arguments.split(' '));
    command
}

/// Runs a command, which must succeed, and returns its standard output.
fn output(nodes: &Nodes, command: &mut Command) -> String {
    let (status, text, error) = nodes.run(command);
    assert!(status.success(), "{command:?}: {text}\n{error}");
    text
}

/// Repeats a `ros2` command until its output contains all `expected` texts, because a new process
/// needs time to discover the nodes. Returns standard output and standard error.
fn output_with(nodes: &Nodes, arguments: &str, expected: &[&str]) -> String {
    let end = Instant::now() + TIMEOUT;
    loop {
        let (_, text, error) = nodes.run(&mut ros2(nodes, arguments));
        // Refusals are printed to standard error.
        let text = text + &error;
        match expected.iter().find(|part| !text.contains(**part)) {
            None => return text,
            Some(part) => {
                let is_in_time = Instant::now() < end;
                assert!(is_in_time, "`ros2 {arguments}` does not print '{part}': {text}");
            }
        }
    }
}

/// Starts a simulator that publishes images without any request.
fn simulator() -> Nodes {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&SIMULATOR);
    nodes
}

/// Starts a simulator and a training run that outlasts the test.
fn training() -> Nodes {
    let mut nodes = simulator();
    let out = format!("out:='{}'", nodes.path("run").display());
    nodes.start_agent("train", &["episodes:=100000", &out]);
    nodes
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn topic_list_echo_and_info_work() {
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
fn the_rviz_configuration_uses_published_topics() {
    let nodes = simulator();
    let file = repository().join("launch_scripts/rviz/evac.rviz");
    let settings = std::fs::read_to_string(file).expect("the RViz configuration is readable");
    let values = settings.lines().filter_map(|line| line.trim().strip_prefix("Value: "));
    let topics: Vec<&str> = values.filter(|value| value.starts_with('/')).collect();
    assert!(topics.contains(&"/camera/image") && topics.contains(&"/scene"), "{topics:?}");
    output_with(&nodes, "topic list --no-daemon", &topics);
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn topic_hz_measures_the_image_rate() {
    let nodes = simulator();
    // `ros2 topic hz` does not exit on its own.
    let log = nodes.path("rate");
    let mut hz = ros2(&nodes, "topic hz /camera/image")
        .env("PYTHONUNBUFFERED", "1")
        .stdout(std::fs::File::create(&log).expect("a file"))
        .stderr(Stdio::null())
        .spawn()
        .expect("ros2 starts");
    let end = Instant::now() + TIMEOUT;
    let is_measured = loop {
        let text = std::fs::read_to_string(&log).unwrap_or_default();
        if text.contains("average rate: ") || Instant::now() > end {
            break text.contains("average rate: ");
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    hz.kill().expect("a child process");
    hz.wait().expect("a child process");
    assert!(is_measured, "`ros2 topic hz` prints no rate");
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn node_info_lists_topics_and_services() {
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
fn param_list_get_describe_set_and_dump_work() {
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
fn service_call_resets_and_steps_the_simulator() {
    let nodes = simulator();
    let call = |nodes: &Nodes, service: &str, request: &str| {
        output(nodes, ros2(nodes, &format!("service call {service}")).arg(request))
    };
    let reset = call(&nodes, "/reset evac_msgs/srv/Reset", "{seed: 7, scenario: concave}");
    assert!(reset.contains("success=True"), "{reset}");
    let step = call(&nodes, "/step evac_msgs/srv/Step", "{action: 3}");
    assert!(step.contains("success=True") && step.contains("step=1"), "{step}");
    let refused = call(&nodes, "/step evac_msgs/srv/Step", "{action: 9}");
    assert!(refused.contains("success=False") && refused.contains("0 to 6"), "{refused}");
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn a_bag_of_a_training_run_can_be_recorded_and_played() {
    let mut nodes = training();
    let bag = nodes.path("bag");
    let bag = bag.to_str().expect("a UTF-8 path");
    let mut recorder = ros2(&nodes, "bag record --output")
        .args([bag, "/camera/image", "/odom"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("ros2 starts");
    // The recorder does not report its progress.
    std::thread::sleep(Duration::from_secs(5));
    interrupt(&recorder);
    assert!(recorder.wait().expect("a child process").success());
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
    player.wait().expect("a child process");
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn launch_files_train_a_model() {
    let nodes = Nodes::new();
    for file in ["train.launch.py", "train.launch.xml"] {
        let out = nodes.path(file);
        let file = repository().join("launch_scripts/launch").join(file);
        let file = file.to_str().expect("a UTF-8 path");
        let mut launch = ros2(&nodes, "launch");
        launch.args([file, "scenario:=concave", "episodes:=5", "seed:=3"]);
        launch.arg(format!("out:={}", out.display()));
        let text = output(&nodes, &mut launch);
        assert!(out.join("summary.json").exists(), "{text}");
    }
}

/// Waits until `evac`, run by `ros2 launch`, has started an agent that is not among `previous`, and
/// returns its process ID.
fn wait_for_agent(launch: &Child, previous: &[String]) -> String {
    let end = Instant::now() + TIMEOUT;
    loop {
        for evac in children("evac", &launch.id().to_string()) {
            let mut agents = children("agent_node", &evac).into_iter();
            if let Some(agent) = agents.find(|agent| !previous.contains(agent)) {
                return agent;
            }
        }
        assert!(Instant::now() < end, "no new agent within {TIMEOUT:?}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Returns the IDs of the child processes of `parent` with this name.
fn children(name: &str, parent: &str) -> Vec<String> {
    let processes = fs::read_dir("/proc").expect("/proc is mounted");
    // proc_pid_stat(5): pid (comm) state ppid ...
    let found = processes.flatten().filter_map(|process| {
        let text = fs::read_to_string(process.path().join("stat")).ok()?;
        let (id, rest) = text.split_once(&format!(" ({name}) "))?;
        (rest.split(' ').nth(1) == Some(parent)).then(|| id.to_owned())
    });
    found.collect()
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn a_launched_agent_that_fails_resumes_its_training() {
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
        agents.push(wait_for_agent(&launch, &agents));
        let checkpoint = out.join("checkpoint.safetensors");
        let before = fs::metadata(&checkpoint).and_then(|file| file.modified()).ok();
        let end = Instant::now() + TIMEOUT;
        while fs::metadata(&checkpoint).and_then(|file| file.modified()).ok() == before {
            assert!(Instant::now() < end, "no new checkpoint within {TIMEOUT:?}");
            std::thread::sleep(Duration::from_millis(20));
        }
        let agent = agents.last().expect("an agent");
        let status = Command::new("kill").args(["-ABRT", agent]).status();
        assert!(status.expect("kill runs").success());
    }
    assert!(launch.wait().expect("a child process").success());
    let episodes = fs::read_to_string(out.join("episodes.csv")).expect("episodes");
    assert_eq!(episodes.lines().count(), 1001);
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn a_launch_file_drives_with_a_trained_model() {
    let mut nodes = Nodes::new();
    let model = nodes.path("run");
    let out = format!("out:='{}'", model.display());
    nodes.start_simulator(&[]);
    nodes.start_agent("train", &["episodes:=5", "evaluation_episodes:=0", &out]);
    nodes.succeed("agent_node", TIMEOUT);
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
    launch.wait().expect("a child process");
}

/// Returns a command that runs one of the rclpy examples.
fn example(nodes: &Nodes, name: &str) -> Command {
    let mut command = nodes.command("python3");
    command.arg(repository().join("launch_scripts/examples").join(name));
    command
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn the_room_example_steps_the_simulator() {
    let nodes = simulator();
    let text = output(&nodes, &mut example(&nodes, "room.py"));
    assert!(text.contains("step 1: action "), "{text}");
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn the_teleoperation_example_drives_the_robot() {
    let nodes = simulator();
    let watcher = nodes.client();
    let statuses = watcher.create_subscription("episode", reliable(100)).expect("a subscription");
    // The example needs a terminal, which `script` provides. `script` takes a shell command line,
    // and the debug format of `Command` is a valid one.
    let program = format!("{:?}", example(&nodes, "teleoperation.py"));
    let mut teleoperation = nodes
        .command("script")
        .args(["--quiet", "--return", "--command", &program, "/dev/null"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("script starts");
    let mut keys = teleoperation.stdin.take().expect("piped input");
    let mut press = |key: &str| {
        keys.write_all(key.as_bytes()).and_then(|()| keys.flush()).expect("an open pipe");
    };
    // Each key is pressed repeatedly until it takes effect, because discovery takes time.
    let end = Instant::now() + TIMEOUT;
    for (key, action) in [("\x1b[A", 3), ("\x1b[D", 4), ("d", 1)] {
        loop {
            press(key);
            let next = async { timeout(Duration::from_secs(1), statuses.async_take()).await };
            let status = watcher.block_on(next).map(|status| status.expect("a valid status").0);
            if status.is_ok_and(|status: EpisodeStatus| status.action == action) {
                break;
            }
            assert!(Instant::now() < end, "the key for action {action} has no effect");
        }
    }
    press("q");
    assert!(teleoperation.wait().expect("a child process").success());
}

#[test]
#[ignore = "needs ROS 2: EVAC_ROS2=required launch_scripts/test.sh --all"]
fn the_bridge_example_resizes_images_and_moves_the_robot() {
    let nodes = simulator();
    // The simulator's camera acts as the robot's. Its images already have the agent's size, so the
    // bridge must not change them.
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
    let resized: Image = wait_for(&watcher, &small, |_| true);
    let original: Image =
        wait_for(&watcher, &large, |image: &Image| image.header.stamp >= resized.header.stamp);
    assert_eq!(resized.data, original.data, "the bridge changed an image");
    let velocities = watcher.create_subscription::<Twist>("cmd_vel", reliable(100));
    let velocities = velocities.expect("a subscription");
    let end = Instant::now() + TIMEOUT;
    // The bridge publishes no velocity while no move is in progress.
    while velocities.take().expect("a valid message").is_none() {
        assert!(Instant::now() < end, "the bridge does not move the robot");
        let image: Image = wait_for(&watcher, &small, |_| true);
        let header = Header { stamp: image.header.stamp, ..Header::default() };
        actions.publish_with(|| ActionCommand { header, action: 5, sent_by_service: false });
    }
    interrupt(&bridge);
    bridge.wait().expect("a child process");
}

/// Returns the next message that satisfies a condition.
fn wait_for<M: RosMessage>(
    node: &Node,
    subscription: &Subscription<M>,
    condition: impl Fn(&M) -> bool,
) -> M {
    let message = async {
        loop {
            let (message, _) = subscription.async_take().await.expect("a valid message");
            if condition(&message) {
                return message;
            }
        }
    };
    node.block_on(async { timeout(TIMEOUT, message).await }).expect("a message before the timeout")
}

/// Sends SIGINT, as Ctrl-C does.
fn interrupt(child: &std::process::Child) {
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(status.expect("kill runs").success());
}
