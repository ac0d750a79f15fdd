//! Checks topics and services with CycloneDDS, an independent DDS implementation.

use std::{
    io::{BufRead, BufReader},
    process::Stdio,
};

use evac_tests::{Nodes, TIMEOUT, assert_calls_the_services};
use ros_runtime::{
    corrections::is_corrected,
    parameters::{ParameterClient, ParameterValue},
};

const FRAMES: u64 = 50;

fn read_images(nodes: &Nodes, options: &[&str]) -> serde_json::Value {
    let mut reader = nodes.peer("image_reader.py");
    reader
        .args(["--frames", &FRAMES.to_string(), "--timeout", &TIMEOUT.as_secs().to_string()])
        .args(options);
    let (status, text, error) = nodes.run(&mut reader);
    assert!(status.success(), "{options:?}: {error}");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn cyclone_dds_receives_the_images_of_a_training_run() {
    let mut nodes = Nodes::new();
    let out = format!("out:='{}'", nodes.path("run").display());
    nodes.start_simulator(&[]);
    nodes.start_agent("train", &["episodes:=100000", &out]);
    for options in [&[][..], &["--best-effort"]] {
        let images = read_images(&nodes, options);
        let expected = serde_json::json!({
            "frames": FRAMES, "width": 20, "height": 7, "encoding": "rgb8", "step": 60,
            "bytes": 420, "frame_id": "camera_optical_frame", "stamps_increase": true,
        });
        assert_eq!(images, expected, "{options:?}");
    }
}

#[test]
fn cyclone_dds_receives_diagnostics_and_parameter_events() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&[]);
    let timeout = TIMEOUT.as_secs().to_string();
    let mut watcher = nodes.peer("node_watcher.py");
    watcher.args(["--node", "/sim_node", "--parameter", "scenario", "--timeout", &timeout]);
    let mut watcher = watcher.stdout(Stdio::piped()).spawn().expect("the watcher starts");
    let output = watcher.stdout.take().expect("piped output");
    let mut lines = BufReader::new(output).lines().map(|line| line.expect("UTF-8"));
    assert_eq!(lines.next().as_deref(), Some("listening"));
    let mut node = nodes.client();
    let parameters = ParameterClient::new(&mut node, "sim_node").expect("a client");
    let concave = ParameterValue::String("concave".to_owned());
    let set = node.block_on(parameters.set("scenario", concave, TIMEOUT));
    assert_eq!(set, Ok(Ok(())));
    let report: serde_json::Value =
        serde_json::from_str(&lines.next().expect("a report")).expect("JSON");
    assert!(watcher.wait().expect("a child process").success());
    let expected = serde_json::json!({
        "parts": {
            "DDS": u8::from(!is_corrected()), "camera": 0, "perturbations": 0, "room": 0,
        },
        "changed": ["concave"],
    });
    assert_eq!(report, expected);
}

/// Checks the Gymnasium example with CycloneDDS in place of rclpy.
#[test]
fn the_gymnasium_example_passes_the_environment_checker() {
    let mut nodes = Nodes::new();
    nodes.set_variable("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp");
    nodes.start_simulator(&["max_steps:=50"]);
    let mut check = nodes.peer("gymnasium_check.py");
    let (status, text, error) =
        nodes.run(check.args(["--timeout", &TIMEOUT.as_secs().to_string()]));
    assert!(status.success(), "{error}");
    let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(found, serde_json::json!({ "episodes": 3, "repeats": true }));
    assert!(!error.contains("WARN"), "{error}");
}

#[test]
fn cyclone_dds_calls_the_services_with_the_mapping_of_rmw_cyclonedds() {
    let mut nodes = Nodes::new();
    nodes.set_variable("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp");
    nodes.start_simulator(&[]);
    assert_calls_the_services(&nodes, nodes.peer("service_caller.py"));
}
