//! SROS2 with `Enforce`: checks that participants can do what their permissions allow and nothing
//! else. The permissions are those of `launch_scripts/security/evac.policy.xml`.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use evac_msgs::{ActionCommand, Reset, Step, reset, step};
use evac_tests::{
    Nodes, Outcome, TIMEOUT, assert_calls_the_services, binary, fast_dds_peer, repository,
};
use learning::{settings::Preset, training::Plan};
use ros_interfaces::sensor_msgs::Image;
use ros_runtime::{Node, node::reliable, security::Security};

/// A secured domain with a keystore.
struct Secured {
    nodes: Nodes,
    keystore: PathBuf,
}

impl Secured {
    fn new() -> Secured {
        let mut nodes = Nodes::new();
        let keystore = make_keystore(&nodes, "keystore");
        for (name, value) in [
            ("ROS_SECURITY_ENABLE", "true"),
            ("ROS_SECURITY_STRATEGY", "Enforce"),
            ("ROS_SECURITY_KEYSTORE", keystore.to_str().expect("a UTF-8 path")),
        ] {
            nodes.set_variable(name, value);
        }
        Secured { nodes, keystore }
    }

    /// Starts `sim_node` in its enclave with the given parameters.
    fn start_simulator(&mut self, parameters: &[&str]) {
        let enclave = ["--ros-args", "--enclave", "/evac/sim_node"];
        let parameters = parameters.iter().flat_map(|parameter| ["-p", *parameter]);
        let arguments: Vec<&str> = enclave.into_iter().chain(parameters).collect();
        self.nodes.start_beside("sim_node", "sim_node", &arguments);
    }

    /// Creates a node in this process with the keys of an enclave.
    fn client(&self, enclave: &str) -> Node {
        self.client_of(&self.keystore, enclave)
    }

    /// Creates a node like [`Secured::client`], with the keys of another keystore.
    fn client_of(&self, keystore: &Path, enclave: &str) -> Node {
        self.nodes.client_with(Security::Enclave(keystore.join("enclaves/evac").join(enclave)))
    }

    /// Creates a node like [`Secured::client`] that does not check its own permissions, so that
    /// only the other participants can refuse it.
    fn unguarded_client(&self, enclave: &str) -> Node {
        let enclaves = self.keystore.join("enclaves");
        let directory = enclaves.join("unguarded").join(enclave);
        fs::create_dir_all(&directory).expect("a directory");
        for file in fs::read_dir(enclaves.join("evac").join(enclave)).expect("an enclave") {
            let file = file.expect("a file");
            fs::copy(file.path(), directory.join(file.file_name())).expect("a copy");
        }
        fs::copy(enclaves.join("unguarded.p7s"), directory.join("governance.p7s")).expect("a copy");
        self.nodes.client_with(Security::Enclave(directory))
    }
}

/// Creates a keystore with its own certificate authority.
fn make_keystore(nodes: &Nodes, name: &str) -> PathBuf {
    let keystore = nodes.path(name);
    let policy = repository().join("launch_scripts/security/evac.policy.xml");
    let mut maker = nodes.peer("keystore.py");
    maker.arg("--policy").arg(policy).arg(&keystore);
    let (status, _, error) = nodes.run(&mut maker);
    assert!(status.success(), "{error}");
    keystore
}

/// Returns whether a node receives a camera image before the timeout.
fn receives_an_image(node: &Node, timeout: Duration) -> bool {
    // The node's own permissions may forbid the subscription.
    let Ok(images) = node.create_subscription::<Image>("camera/image", reliable(5)) else {
        return false;
    };
    let first = node.block_on(async { tokio::time::timeout(timeout, images.async_take()).await });
    first.is_ok_and(|image| image.expect("a valid image").0.data.len() == 420)
}

/// Calls `/step`; returns `None` if there is no response before the timeout.
fn call_step(node: &mut Node, request: step::Request, timeout: Duration) -> Option<step::Response> {
    let steps = node.create_client::<Step>("step").ok()?;
    node.block_on(steps.call(request, Some(timeout))).ok()
}

/// Tries to step the simulator through `/action` and `/step`. Returns whether the service responds.
fn can_step(node: &mut Node, timeout: Duration) -> bool {
    let commands = node.create_publisher::<ActionCommand>("action", reliable(1));
    if let Ok(commands) = &commands {
        commands.publish(ActionCommand::default());
    }
    call_step(node, step::Request { episode: 0, step: 0, action: 0 }, timeout).is_some()
}

#[test]
fn secured_training_has_the_same_result_as_unsecured_training() {
    let mut secured = Secured::new();
    let out = secured.nodes.path("run");
    secured.start_simulator(&["max_steps:=60"]);
    let out_parameter = format!("out:='{}'", out.display());
    let mut arguments = vec!["train", "--ros-args", "--enclave", "/evac/agent_node"];
    for parameter in ["episodes:=12", "seed:=5", "evaluation_episodes:=5", &out_parameter] {
        arguments.extend(["-p", parameter]);
    }
    secured.nodes.start_beside("agent_node", "agent_node", &arguments);
    secured.nodes.succeed("agent_node", 5 * TIMEOUT);
    let plan = Plan { scenario: task::seeds::MIXED.to_owned(), episodes: 12, seed: 5, rooms: 1 };
    let here = secured.nodes.path("here");
    let expected = Outcome::in_process(plan, Preset::default(), 60, &here);
    Outcome::read_from(&out).assert_identical(&expected);
    // The figures need further permissions: parameters of sim_node, topics /tf and /scene.
    assert!(out.join("figures/paths.svg").exists());
}

#[test]
fn only_permitted_participants_receive_images_or_step() {
    let mut secured = Secured::new();
    secured.start_simulator(&["frame_rate:=20.0"]);

    // Permitted participants come first: the time they take determines the timeout for the others.
    let begin = Instant::now();
    let mut operator = secured.client("operator");
    let resets = operator.create_client::<Reset>("reset").expect("permission to reset");
    let request = reset::Request { request: 1, seed: 7, scenario: String::new() };
    let reset = operator.block_on(resets.call(request, Some(TIMEOUT))).expect("a response");
    assert!(reset.success, "{}", reset.message);
    let mut number = 0;
    let mut assert_operator_steps = || {
        number += 1;
        // The action differs from that of the other participants: if one of them had executed this
        // step, the request would be refused.
        let request = step::Request { episode: reset.episode, step: number, action: 1 };
        let response = call_step(&mut operator, request, TIMEOUT).expect("permission to step");
        assert!(response.success, "step {number}: {}", response.message);
    };
    assert_operator_steps();
    assert!(receives_an_image(&secured.client("spectator"), TIMEOUT));
    let timeout = 2 * begin.elapsed();

    let foreign = make_keystore(&secured.nodes, "foreign");
    for (description, mut node, may_receive_images) in [
        ("without keys", secured.nodes.client(), false),
        ("with keys of another authority", secured.client_of(&foreign, "sim_node"), false),
        ("without permission to step", secured.client("spectator"), true),
        // Participants with a different governance document are refused entirely.
        ("that does not check its permissions", secured.unguarded_client("spectator"), false),
    ] {
        let receives_images = receives_an_image(&node, timeout);
        assert_eq!(receives_images, may_receive_images, "participant {description}");
        assert!(!can_step(&mut node, timeout), "participant {description}");
        assert_operator_steps();
    }
    for (description, node) in [
        ("without permission to receive images", secured.client("operator")),
        ("that does not check its permissions", secured.unguarded_client("operator")),
    ] {
        assert!(!receives_an_image(&node, timeout), "participant {description}");
    }
}

#[test]
fn cyclone_dds_without_keys_receives_nothing_and_finds_no_service() {
    let mut secured = Secured::new();
    secured.nodes.set_variable("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp");
    secured.start_simulator(&["frame_rate:=20.0"]);
    let begin = Instant::now();
    assert!(receives_an_image(&secured.client("spectator"), TIMEOUT));
    let timeout = (2 * begin.elapsed()).as_secs_f64().to_string();
    for (name, options, expected) in [
        ("image_reader.py", ["--frames", "1"], "received 0 of 1 images on /camera/image"),
        ("service_caller.py", ["--steps", "1"], "no server for /reset"),
    ] {
        let mut peer = secured.nodes.peer(name);
        let (status, _, error) =
            secured.nodes.run(peer.args(options).args(["--timeout", &timeout]));
        assert!(!status.success() && error.contains(expected), "{name}: {error}");
    }
}

#[test]
fn fast_dds_steps_only_with_permission() {
    let peer = fast_dds_peer();
    let mut secured = Secured::new();
    secured.nodes.set_variable("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp");
    secured.start_simulator(&[]);
    let caller = |enclave: &str| {
        let mut caller = secured.nodes.command(&peer);
        caller.env("ROS_SECURITY_ENCLAVE_OVERRIDE", enclave);
        caller
    };
    let begin = Instant::now();
    assert_calls_the_services(&secured.nodes, caller("/evac/operator"));
    let timeout = (2 * begin.elapsed()).as_secs().max(1).to_string();

    let foreign = make_keystore(&secured.nodes, "foreign");
    let mut foreigner = caller("/evac/operator");
    foreigner.env("ROS_SECURITY_KEYSTORE", foreign);
    let mut insecure = caller("/evac/operator");
    insecure.env("ROS_SECURITY_ENABLE", "false");
    for (mut caller, expected) in [
        (caller("/evac/spectator"), "cannot create a client of /reset"),
        (foreigner, "no server for /reset"),
        (insecure, "no server for /reset"),
    ] {
        let (status, _, error) =
            secured.nodes.run(caller.args(["--steps", "1", "--timeout", &timeout]));
        assert!(!status.success() && error.contains(expected), "{error}");
    }
}

#[test]
fn a_node_with_missing_or_invalid_keys_does_not_start() {
    let secured = Secured::new();
    let enclave = secured.keystore.join("enclaves/evac/sim_node");
    let startup_error = |name: &str| {
        let mut node = secured.nodes.command(binary("sim_node"));
        let (status, _, text) = secured.nodes.run(node.args(["--ros-args", "--enclave", name]));
        assert_eq!(status.code(), Some(1), "{text}");
        text
    };
    let text = startup_error("/nowhere");
    assert!(text.contains("ROS_SECURITY_STRATEGY=Enforce, but there is no enclave"), "{text}");
    fs::remove_file(enclave.join("permissions.p7s")).expect("the file exists");
    let text = startup_error("/evac/sim_node");
    assert!(text.contains("is incomplete: permissions.p7s is missing"), "{text}");
    // The file is not signed.
    fs::write(enclave.join("permissions.p7s"), "anything").expect("a file");
    let text = startup_error("/evac/sim_node");
    assert!(text.contains("could not join DDS domain"), "{text}");
}
