//! Bad input, as a user may give it: one clear line each, and an exit status that is not 0.

use std::fs;

use evac_tests::{Nodes, binary};
use ros_runtime::corrections::is_corrected;

/// What a node says, and that it says it in one line.
fn complaint(nodes: &Nodes, name: &str, arguments: &[&str]) -> String {
    let (status, _, text) = nodes.run(nodes.command(binary(name)).args(arguments));
    assert_eq!(status.code(), Some(1), "{arguments:?}: {text}");
    // An uncorrected build warns of itself, too.
    let is_other = |line: &&str| line.starts_with("[INFO]") || line.contains("(uncorrected)");
    let lines: Vec<&str> = text.lines().filter(|line| !is_other(line)).collect();
    assert_eq!(lines.len(), 1, "{arguments:?}: {text}");
    lines[0].to_owned()
}

#[test]
fn wrong_parameters_and_arguments() {
    let nodes = Nodes::new();
    let agent = ["train", "--ros-args"];
    for (arguments, expected) in [
        (
            &["-p", "preset:=nonsense"][..],
            "parameter 'preset' is the string 'nonsense': expected one of paper",
        ),
        (&["-p", "episodes:=abc"], "parameter 'episodes' is the string 'abc': expected an integer"),
        (&["-p", "episodes:=0"], "parameter 'episodes' is the integer 0: expected 1 to"),
        (&["-p", "epsiodes:=5"], "no parameter 'epsiodes'"),
        (&["-p", "scenario:=desert"], "expected one of empty, one_cylinder"),
        (&["-r", "nonsense"], "couldn't parse the remapping 'nonsense'"),
        (&["--params-file", "nowhere.yaml"], "parameter file nowhere.yaml: No such file"),
        (&["-p", "resume:=true", "-p", "out:=/nowhere/run"], "/nowhere/run"),
    ] {
        let line = complaint(&nodes, "agent_node", &[&agent, arguments].concat());
        assert!(line.starts_with("agent_node: ") && line.contains(expected), "{line}");
    }
    for (arguments, expected) in [
        (&["-p", "scenario:=desert"][..], "expected one of empty"),
        (&["-p", "camera.height:=0.5"], "a camera at a height of 0.5 m cannot be"),
        (&["-p", "fixed_robot:=[0.0, 0.0]"], "the fixed robot's pose has 2 numbers"),
        (&["-p", "fixed_robot:=[9.0, 0.0, 0.0]"], "the room cannot be laid out"),
    ] {
        let line = complaint(&nodes, "sim_node", &[&["--ros-args"], arguments].concat());
        assert!(line.starts_with("sim_node: ") && line.contains(expected), "{line}");
    }
}

#[test]
fn the_version_and_the_start_tell_whether_rustdds_is_corrected() {
    let mut nodes = Nodes::new();
    let word = if is_corrected() { "(corrected)" } else { "(uncorrected)" };
    for name in ["sim_node", "agent_node"] {
        let (status, version, _) = nodes.run(nodes.command(binary(name)).arg("--version"));
        assert!(status.success());
        assert_eq!(version.trim(), format!("{name} 0.1.0, RustDDS 0.15.1 {word}"));
    }
    nodes.start_simulator(&[]);
    nodes.wait_for_log("sim_node", "the room is open");
    let log = nodes.log("sim_node");
    let is_warned = log.lines().any(|line| line.contains("[WARN]") && line.contains(word));
    assert_eq!(is_warned, !is_corrected(), "{log}");
}

/// It does not start less secure than somebody wants it.
#[cfg(not(feature = "security"))]
#[test]
fn a_build_without_security_refuses_to_be_secured() {
    let mut nodes = Nodes::new();
    nodes.set_variable("ROS_SECURITY_ENABLE", "true");
    for name in ["sim_node", "agent_node"] {
        let command = if name == "agent_node" { &["train"][..] } else { &[] };
        let line = complaint(&nodes, name, command);
        assert!(line.contains("this node was built without security: expected"), "{line}");
    }
}

#[test]
fn missing_and_damaged_models() {
    let mut nodes = Nodes::new();
    let run = nodes.path("run");
    let out = format!("out:='{}'", run.display());
    nodes.start_simulator(&["max_steps:=20"]);
    nodes.start_agent("train", &["episodes:=2", "evaluation_episodes:=0", &out]);
    nodes.succeed("agent_node", evac_tests::PATIENCE);

    let model = format!("model:='{}'", run.display());
    let evaluate =
        |nodes: &Nodes| complaint(nodes, "agent_node", &["evaluate", "--ros-args", "-p", &model]);
    let line =
        complaint(&nodes, "agent_node", &["evaluate", "--ros-args", "-p", "model:=/nowhere"]);
    assert!(line.contains("no trained model in /nowhere"), "{line}");
    let line = complaint(&nodes, "agent_node", &["evaluate"]);
    assert!(line.contains("parameter 'model' is missing"), "{line}");

    let config = run.join("config.yaml");
    let text = fs::read_to_string(&config).expect("config.yaml");
    for (from, to, expected) in [
        ("observation_frames: 4", "observation_frames: 1000000000", "expected 1 to 64"),
        ("observation_frames: 4", "observation_frames: -4", "expected 1 to 64"),
        ("avoid_repetition: true", "avoid_repetition: maybe", "avoid_repetition is"),
    ] {
        assert!(text.contains(from), "{text}");
        fs::write(&config, text.replace(from, to)).expect("another configuration");
        let line = evaluate(&nodes);
        assert!(line.contains(expected), "{line}");
    }
    fs::write(&config, text).expect("the configuration as it was");

    let file = run.join("model.safetensors");
    let bytes = fs::read(&file).expect("the model");
    fs::write(&file, &bytes[..bytes.len() / 2]).expect("half of it");
    let line = evaluate(&nodes);
    assert!(line.contains("model.safetensors is damaged or no safetensors file"), "{line}");
    fs::write(&file, b"").expect("nothing of it");
    assert!(evaluate(&nodes).contains("model.safetensors is damaged"));
    fs::remove_file(&file).expect("it was there");
    assert!(evaluate(&nodes).contains("model.safetensors: No such file"));

    let checkpoint = run.join("checkpoint.safetensors");
    let bytes = fs::read(&checkpoint).expect("the checkpoint");
    let resume = ["train", "--ros-args", "-p", "resume:=true", "-p", "episodes:=2", "-p", &out];
    let other = [&resume[..], &["-p", "seed:=9"]].concat();
    assert!(complaint(&nodes, "agent_node", &other).contains("does not fit: its seed is 0, not 9"));
    fs::write(&checkpoint, &bytes[..bytes.len() - 100]).expect("most of it");
    let line = complaint(&nodes, "agent_node", &resume);
    assert!(line.contains("checkpoint.safetensors is damaged"), "{line}");
}

#[test]
fn the_console_is_written_as_the_environment_says() {
    let mut nodes = Nodes::new();
    nodes.set_variable("RCUTILS_COLORIZED_OUTPUT", "maybe");
    let line = complaint(&nodes, "sim_node", &[]);
    assert_eq!(line, "sim_node: RCUTILS_COLORIZED_OUTPUT is 'maybe': expected 0 or 1");
    nodes.set_variable("RCUTILS_COLORIZED_OUTPUT", "1");
    nodes.set_variable("RCUTILS_CONSOLE_OUTPUT_FORMAT", "<{severity}> {message}");
    nodes.start_simulator(&[]);
    nodes.wait_for_log("sim_node", "\x1b[0m<INFO> the room is open");
    // Nothing but the last word, which is no log.
    let arguments = ["--ros-args", "--disable-stdout-logs", "-p", "fixed_robot:=[9.0, 0.0, 0.0]"];
    let (_, _, text) = nodes.run(nodes.command(binary("sim_node")).args(arguments));
    assert!(text.starts_with("sim_node: "), "{text}");
}
