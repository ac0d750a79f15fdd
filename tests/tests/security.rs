//! SROS2 with `Enforce`: who may do what, each by a participant that tries. The keys are those of
//! `launch_scripts/security/evac.policy.xml`.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use evac_msgs::{ActionCommand, Reset, Step, reset, step};
use evac_tests::{
    Nodes, Outcome, PATIENCE, assert_calls_the_services, binary, fast_dds_peer, repository,
};
use learning::{settings::Preset, training::Plan};
use ros_interfaces::sensor_msgs::Image;
use ros_runtime::{Node, node::reliable, security::Security};

/// A domain in which everybody should have keys.
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
            ("ROS_SECURITY_KEYSTORE", keystore.to_str().expect("a path in Unicode")),
        ] {
            nodes.set_variable(name, value);
        }
        Secured { nodes, keystore }
    }

    /// Starts the room with parameters.
    fn start_simulator(&mut self, parameters: &[&str]) {
        let own = ["--ros-args", "--enclave", "/evac/sim_node"];
        let parameters = parameters.iter().flat_map(|parameter| ["-p", *parameter]);
        let arguments: Vec<&str> = own.into_iter().chain(parameters).collect();
        self.nodes.start_beside("sim_node", "sim_node", &arguments);
    }

    /// A node of this process with the keys of an enclave.
    fn client(&self, enclave: &str) -> Node {
        self.client_of(&self.keystore, enclave)
    }

    /// As [`Secured::client`], with the keys of another keystore.
    fn client_of(&self, keystore: &Path, enclave: &str) -> Node {
        self.nodes.client_with(Security::Enclave(keystore.join("enclaves/evac").join(enclave)))
    }

    /// As [`Secured::client`], but the node does not ask itself whether it may do something: it is
    /// for the others to refuse it.
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

/// A keystore with an authority of its own.
fn make_keystore(nodes: &Nodes, name: &str) -> PathBuf {
    let keystore = nodes.path(name);
    let policy = repository().join("launch_scripts/security/evac.policy.xml");
    let mut maker = nodes.peer("keystore.py");
    maker.arg("--policy").arg(policy).arg(&keystore);
    let (status, _, error) = nodes.run(&mut maker);
    assert!(status.success(), "{error}");
    keystore
}

/// Whether a camera image comes to a node within a time.
fn sees_a_frame(node: &Node, patience: Duration) -> bool {
    // Its own side may refuse it, too.
    let Ok(images) = node.create_subscription::<Image>("camera/image", reliable(5)) else {
        return false;
    };
    let first = node.block_on(async { tokio::time::timeout(patience, images.async_take()).await });
    first.is_ok_and(|image| image.expect("a readable image").0.data.len() == 420)
}

/// Asks for a step: the answer, if there is one.
fn ask(node: &mut Node, request: step::Request, patience: Duration) -> Option<step::Response> {
    let steps = node.create_client::<Step>("step").ok()?;
    node.block_on(steps.call(request, Some(patience))).ok()
}

/// Tries to step the room, whatever its state, by a command and by the service: whether the service
/// answers.
fn steps(node: &mut Node, patience: Duration) -> bool {
    let commands = node.create_publisher::<ActionCommand>("action", reliable(1));
    if let Ok(commands) = &commands {
        commands.publish(ActionCommand::default());
    }
    ask(node, step::Request { episode: 0, step: 0, action: 0 }, patience).is_some()
}

#[test]
fn a_secured_pair_trains_to_the_same_result_as_an_insecure_one() {
    let mut secured = Secured::new();
    let out = secured.nodes.path("run");
    secured.start_simulator(&["max_steps:=60"]);
    let out_parameter = format!("out:='{}'", out.display());
    let mut arguments = vec!["train", "--ros-args", "--enclave", "/evac/agent_node"];
    for parameter in ["episodes:=12", "seed:=5", "evaluation_episodes:=5", &out_parameter] {
        arguments.extend(["-p", parameter]);
    }
    secured.nodes.start_beside("agent_node", "agent_node", &arguments);
    secured.nodes.succeed("agent_node", 5 * PATIENCE);
    let plan = Plan { scenario: "empty".to_owned(), episodes: 12, seed: 5, rooms: 1 };
    let here = secured.nodes.path("here");
    let expected = Outcome::in_process(plan, Preset::default(), 60, &here);
    Outcome::left_in(&out).assert_is(&expected);
    // It could hold the room fixed and see where the robot was, which takes permissions of its own.
    assert!(out.join("figures/paths.svg").exists());
}

#[test]
fn only_who_has_permission_sees_a_frame_or_makes_a_step() {
    let mut secured = Secured::new();
    secured.start_simulator(&["frame_rate:=20.0"]);

    // Who may: the measure of how long those may try who may not.
    let begin = Instant::now();
    let mut operator = secured.client("operator");
    let resets = operator.create_client::<Reset>("reset").expect("it may reset");
    let request = reset::Request { request: 1, seed: 7, scenario: String::new() };
    let begun = operator.block_on(resets.call(request, Some(PATIENCE))).expect("an answer");
    assert!(begun.success, "{}", begun.message);
    let mut number = 0;
    let mut assert_operator_steps = || {
        number += 1;
        // Not the action of the others: had one of them made this step, it would be refused.
        let request = step::Request { episode: begun.episode, step: number, action: 1 };
        let answer = ask(&mut operator, request, PATIENCE).expect("the operator may step");
        assert!(answer.success, "step {number}: {}", answer.message);
    };
    assert_operator_steps();
    assert!(sees_a_frame(&secured.client("spectator"), PATIENCE));
    let patience = 2 * begin.elapsed();

    let foreign = make_keystore(&secured.nodes, "foreign");
    for (who, mut node, may_see) in [
        ("without keys", secured.nodes.client(), false),
        ("of another authority", secured.client_of(&foreign, "sim_node"), false),
        ("without permission to step", secured.client("spectator"), true),
        // The others refuse whoever has another governance, in whatever it does.
        ("who tries to step all the same", secured.unguarded_client("spectator"), false),
    ] {
        assert_eq!(sees_a_frame(&node, patience), may_see, "one {who}");
        assert!(!steps(&mut node, patience), "one {who}");
        assert_operator_steps();
    }
    for (who, node) in [
        ("without permission to see", secured.client("operator")),
        ("who tries to see all the same", secured.unguarded_client("operator")),
    ] {
        assert!(!sees_a_frame(&node, patience), "one {who}");
    }
}

#[test]
fn cyclone_dds_without_keys_sees_nothing_and_reaches_nobody() {
    let mut secured = Secured::new();
    secured.nodes.set_variable("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp");
    secured.start_simulator(&["frame_rate:=20.0"]);
    let begin = Instant::now();
    assert!(sees_a_frame(&secured.client("spectator"), PATIENCE));
    let timeout = (2 * begin.elapsed()).as_secs_f64().to_string();
    for (name, options, complaint) in [
        ("image_reader.py", ["--frames", "1"], "0 of 1 frames came on /camera/image"),
        ("service_caller.py", ["--steps", "1"], "nobody serves /reset"),
    ] {
        let mut peer = secured.nodes.peer(name);
        let (status, _, error) =
            secured.nodes.run(peer.args(options).args(["--timeout", &timeout]));
        assert!(!status.success() && error.contains(complaint), "{name}: {error}");
    }
}

#[test]
fn fast_dds_steps_with_permission_and_not_without() {
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
    for (mut caller, complaint) in [
        (caller("/evac/spectator"), "there can be no client of /reset"),
        (foreigner, "nobody serves /reset"),
        (insecure, "nobody serves /reset"),
    ] {
        let (status, _, error) =
            secured.nodes.run(caller.args(["--steps", "1", "--timeout", &timeout]));
        assert!(!status.success() && error.contains(complaint), "{error}");
    }
}

#[test]
fn a_node_whose_keys_are_not_whole_does_not_start() {
    let secured = Secured::new();
    let enclave = secured.keystore.join("enclaves/evac/sim_node");
    let complaint = |name: &str| {
        let mut node = secured.nodes.command(binary("sim_node"));
        let (status, _, text) = secured.nodes.run(node.args(["--ros-args", "--enclave", name]));
        assert_eq!(status.code(), Some(1), "{text}");
        text
    };
    let text = complaint("/nowhere");
    assert!(text.contains("ROS_SECURITY_STRATEGY=Enforce, but there is no enclave"), "{text}");
    fs::remove_file(enclave.join("permissions.p7s")).expect("it was there");
    let text = complaint("/evac/sim_node");
    assert!(text.contains("is not whole: there is no permissions.p7s"), "{text}");
    // Signed by nobody.
    fs::write(enclave.join("permissions.p7s"), "anything").expect("a file");
    let text = complaint("/evac/sim_node");
    assert!(text.contains("could not join DDS domain"), "{text}");
}
