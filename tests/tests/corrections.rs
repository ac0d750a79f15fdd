//! Checks the effects of the RustDDS corrections that are visible to users and other DDS
//! implementations.
//!
//! These tests need a corrected build: `launch_scripts/test.sh` creates one and runs them.

use std::time::Duration;

use evac_tests::{Nodes, TIMEOUT, assert_survives, interfaces};
use ros_runtime::{
    corrections::is_corrected,
    parameters::{ParameterClient, ParameterValue},
};
use serde::Deserialize;

/// Returns an empty domain. Panics if this build is not corrected.
fn nodes() -> Nodes {
    assert!(is_corrected(), "RustDDS is not patched: run launch_scripts/setup.sh and rebuild");
    Nodes::new()
}

/// Starts a training run that outlasts the test and waits for its first step.
fn start_training(nodes: &mut Nodes) {
    let out = format!("out:='{}'", nodes.path("run").display());
    nodes.start_simulator(&[]);
    nodes.start_agent("train", &["episodes:=100000", &out]);
    nodes.wait_for_steps(1);
}

/// An endpoint as announced by discovery.
#[derive(Debug, Deserialize)]
struct Endpoint {
    topic: String,
    r#type: String,
    user_data: String,
}

/// Waits until CycloneDDS has discovered an endpoint on each of `topics`. Returns all discovered
/// endpoints except built-in ones.
fn endpoints(nodes: &Nodes, topics: &[&str]) -> Vec<Endpoint> {
    let mut watcher = nodes.peer("endpoint_watcher.py");
    let timeout = TIMEOUT.as_secs().to_string();
    let (status, text, error) = nodes.run(watcher.args(topics).args(["--timeout", &timeout]));
    assert!(status.success(), "{error}");
    assert_eq!(error, "", "CycloneDDS reported an invalid packet");
    let all: Vec<Endpoint> = serde_json::from_str(&text).expect("JSON");
    all.into_iter().filter(|endpoint| !endpoint.topic.starts_with("DCPS")).collect()
}

/// Returns the ROS name of a DDS type: `sensor_msgs/msg/Image` for
/// `sensor_msgs::msg::dds_::Image_`.
fn ros_name(dds_type: &str) -> String {
    dds_type.replace("dds_::", "").replace("::", "/").trim_end_matches('_').to_owned()
}

#[test]
fn every_endpoint_announces_its_type_hash() {
    let mut nodes = nodes();
    start_training(&mut nodes);
    let topics = [
        "ros_discovery_info",
        "rt/rosout",
        "rt/parameter_events",
        "rt/diagnostics",
        "rt/camera/image",
        "rt/action",
        "rt/training_status",
        "rq/stepRequest",
        "rr/stepReply",
        "rq/agent_node/get_parametersRequest",
        "rr/agent_node/get_type_descriptionReply",
    ];
    let endpoints = endpoints(&nodes, &topics);
    for Endpoint { topic, r#type, user_data } in &endpoints {
        let hash = interfaces().hash(&ros_name(r#type));
        let hash = hash.unwrap_or_else(|| panic!("{topic}: {type} has no definition"));
        assert_eq!(*user_data, format!("typehash={hash};"), "{topic}: {type}");
    }
    for topic in topics {
        assert!(endpoints.iter().any(|endpoint| endpoint.topic == topic), "{topic} is missing");
    }
}

#[test]
fn cyclone_dds_accepts_every_packet_of_a_client_and_a_server() {
    let mut nodes = nodes();
    nodes.set_variable("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp");
    nodes.start_simulator(&[]);
    let mut caller = nodes.peer("service_caller.py");
    let timeout = TIMEOUT.as_secs().to_string();
    let (status, _, error) = nodes.run(caller.args(["--steps", "20", "--timeout", &timeout]));
    assert!(status.success(), "{error}");
    assert_eq!(error, "", "CycloneDDS reported an invalid packet");
}

#[test]
fn all_parameters_can_be_read_during_training() {
    let mut nodes = nodes();
    start_training(&mut nodes);
    let mut node = nodes.client();
    let agent = ParameterClient::new(&mut node, "agent_node").expect("a client");
    for _ in 0..20 {
        let values = node.block_on(agent.values(TIMEOUT)).expect("a response");
        assert_eq!(values.get("preset"), Some(&ParameterValue::String("robust".to_owned())));
    }
}

#[test]
fn training_survives_stopped_and_continued_nodes() {
    assert_survives(nodes(), 10, 0.001, |nodes, name| {
        nodes.signal(name, "STOP");
        std::thread::sleep(Duration::from_millis(100));
        nodes.signal(name, "CONT");
    });
}
