//! Checks that the nodes reject invalid arguments, parameters and files with a one-line error and
//! exit status 1.

use std::fs;

use evac_tests::{Nodes, binary};
use ros_runtime::corrections::is_corrected;

/// Runs a node that must exit with status 1 and returns its error, which must be a single line.
fn startup_error(nodes: &Nodes, name: &str, arguments: &[&str]) -> String {
    let (status, _, text) = nodes.run(nodes.command(binary(name)).args(arguments));
    assert_eq!(status.code(), Some(1), "{arguments:?}: {text}");
    // An uncorrected build also logs a warning.
    let is_other = |line: &&str| line.starts_with("[INFO]") || line.contains("(uncorrected)");
    let lines: Vec<&str> = text.lines().filter(|line| !is_other(line)).collect();
    assert_eq!(lines.len(), 1, "{arguments:?}: {text}");
    lines[0].to_owned()
}

#[test]
fn rejects_invalid_parameters_and_arguments() {
    let nodes = Nodes::new();
    let agent = ["train", "--ros-args"];
    for (arguments, expected) in [
        (
            &["-p", "preset:=nonsense"][..],
            "parameter 'preset' is the string 'nonsense': expected one of paper",
        ),
        (&["-p", "episodes:=abc"], "parameter 'episodes' is the string 'abc': expected an integer"),
        (&["-p", "episodes:=0"], "parameter 'episodes' is the integer 0: expected 1 to"),
        (&["-p", "epsiodes:=5"], "unknown parameter 'epsiodes'"),
        (&["-p", "scenario:=desert"], "expected one of empty, one_cylinder"),
        (&["-r", "nonsense"], "couldn't parse the remapping 'nonsense'"),
        (&["--params-file", "nowhere.yaml"], "parameter file nowhere.yaml: No such file"),
        (&["-p", "resume:=true", "-p", "out:=/nowhere/run"], "/nowhere/run"),
    ] {
        let line = startup_error(&nodes, "agent_node", &[&agent, arguments].concat());
        assert!(line.starts_with("agent_node: ") && line.contains(expected), "{line}");
    }
    for (arguments, expected) in [
        (&["-p", "scenario:=desert"][..], "expected one of empty"),
        (&["-p", "camera.height:=0.5"], "camera height: invalid value 0.5 m"),
        (&["-p", "fixed_robot:=[0.0, 0.0]"], "fixed robot: invalid length 2"),
        (&["-p", "fixed_robot:=[9.0, 0.0, 0.0]"], "the fixed_* parameters do not allow"),
    ] {
        let line = startup_error(&nodes, "sim_node", &[&["--ros-args"], arguments].concat());
        assert!(line.starts_with("sim_node: ") && line.contains(expected), "{line}");
    }
}

#[test]
fn the_version_and_the_log_state_whether_rustdds_is_corrected() {
    let mut nodes = Nodes::new();
    let suffix = if is_corrected() { "(corrected)" } else { "(uncorrected)" };
    for name in ["sim_node", "agent_node"] {
        let (status, version, _) = nodes.run(nodes.command(binary(name)).arg("--version"));
        assert!(status.success());
        let own = env!("CARGO_PKG_VERSION");
        assert_eq!(version.trim(), format!("{name} {own}, RustDDS 0.15.1 {suffix}"));
    }
    nodes.start_simulator(&[]);
    nodes.wait_for_log("sim_node", "simulator ready");
    let log = nodes.log("sim_node");
    let has_warning = log.lines().any(|line| line.contains("[WARN]") && line.contains(suffix));
    assert_eq!(has_warning, !is_corrected(), "{log}");
}

/// A node must not start without security when the environment demands it.
#[cfg(not(feature = "security"))]
#[test]
fn a_build_without_security_refuses_to_start_with_security_enabled() {
    let mut nodes = Nodes::new();
    nodes.set_variable("ROS_SECURITY_ENABLE", "true");
    for name in ["sim_node", "agent_node"] {
        let command = if name == "agent_node" { &["train"][..] } else { &[] };
        let line = startup_error(&nodes, name, command);
        assert!(line.contains("this node was built without security: expected"), "{line}");
    }
}

#[test]
fn rejects_missing_and_damaged_models() {
    let mut nodes = Nodes::new();
    let run = nodes.path("run");
    let out = format!("out:='{}'", run.display());
    nodes.start_simulator(&["max_steps:=20"]);
    nodes.start_agent("train", &["episodes:=2", "evaluation_episodes:=0", &out]);
    nodes.succeed("agent_node", evac_tests::TIMEOUT);

    let model = format!("model:='{}'", run.display());
    let evaluate = |nodes: &Nodes| {
        startup_error(nodes, "agent_node", &["evaluate", "--ros-args", "-p", &model])
    };
    let line =
        startup_error(&nodes, "agent_node", &["evaluate", "--ros-args", "-p", "model:=/nowhere"]);
    assert!(line.contains("no trained model in /nowhere"), "{line}");
    let line = startup_error(&nodes, "agent_node", &["evaluate"]);
    assert!(line.contains("parameter 'model' is missing"), "{line}");

    let config = run.join("config.yaml");
    let text = fs::read_to_string(&config).expect("config.yaml");
    for (from, to, expected) in [
        ("observation_frames: 4", "observation_frames: 1000000000", "expected 1 to 64"),
        ("observation_frames: 4", "observation_frames: -4", "expected 1 to 64"),
        (
            "avoid_repetition: true",
            "avoid_repetition: maybe",
            "'avoid_repetition' is the string 'maybe'",
        ),
    ] {
        assert!(text.contains(from), "{text}");
        fs::write(&config, text.replace(from, to)).expect("config.yaml is writable");
        let line = evaluate(&nodes);
        assert!(line.contains(expected), "{line}");
    }
    fs::write(&config, text).expect("config.yaml is writable");

    let file = run.join("model.safetensors");
    let bytes = fs::read(&file).expect("the model");
    fs::write(&file, &bytes[..bytes.len() / 2]).expect("the model is writable");
    let line = evaluate(&nodes);
    assert!(line.contains("model.safetensors is damaged or not a safetensors file"), "{line}");
    fs::write(&file, b"").expect("the model is writable");
    assert!(evaluate(&nodes).contains("model.safetensors is damaged"));
    fs::remove_file(&file).expect("the model exists");
    assert!(evaluate(&nodes).contains("model.safetensors: No such file"));

    let checkpoint = run.join("checkpoint.safetensors");
    let bytes = fs::read(&checkpoint).expect("the checkpoint");
    let resume = ["train", "--ros-args", "-p", "resume:=true", "-p", "episodes:=2", "-p", &out];
    let other = [&resume[..], &["-p", "seed:=9"]].concat();
    let line = startup_error(&nodes, "agent_node", &other);
    assert!(line.contains("does not match this run: its seed is 0 (expected: 9)"), "{line}");
    fs::write(&checkpoint, &bytes[..bytes.len() - 100]).expect("the checkpoint is writable");
    let line = startup_error(&nodes, "agent_node", &resume);
    assert!(line.contains("checkpoint.safetensors is damaged"), "{line}");
}

#[test]
fn console_output_follows_the_rcutils_variables() {
    let mut nodes = Nodes::new();
    nodes.set_variable("RCUTILS_COLORIZED_OUTPUT", "maybe");
    let line = startup_error(&nodes, "sim_node", &[]);
    assert_eq!(line, "sim_node: RCUTILS_COLORIZED_OUTPUT is 'maybe': expected 0 or 1");
    nodes.set_variable("RCUTILS_COLORIZED_OUTPUT", "1");
    nodes.set_variable("RCUTILS_CONSOLE_OUTPUT_FORMAT", "<{severity}> {message}");
    nodes.start_simulator(&[]);
    nodes.wait_for_log("sim_node", "\x1b[0m<INFO> simulator ready");
    // Only the final error remains, which is not a log line.
    let arguments = ["--ros-args", "--disable-stdout-logs", "-p", "fixed_robot:=[9.0, 0.0, 0.0]"];
    let (_, _, text) = nodes.run(nodes.command(binary("sim_node")).args(arguments));
    assert!(text.starts_with("sim_node: "), "{text}");
}

#[test]
fn a_reader_that_closes_the_pipe_is_not_an_error() {
    let nodes = Nodes::new();
    for (name, arguments) in
        [("agent_node", "seeds --seed 1 --episodes 100000"), ("evac", "completions bash")]
    {
        let program = binary(name).display().to_string();
        let script = format!("{program} {arguments} | head -n 1; exit ${{PIPESTATUS[0]}}");
        let (status, text, error) = nodes.run(nodes.command("bash").args(["-c", &script]));
        assert!(status.success() && error.is_empty(), "{name}: {error}");
        assert_eq!(text.lines().count(), 1, "{name}: {text}");
    }
}

#[test]
fn rejects_a_resume_without_a_checkpoint() {
    let nodes = Nodes::new();
    let out = nodes.path("nothing");
    let parameter = format!("out:='{}'", out.display());
    let arguments = ["train", "--ros-args", "-p", "resume:=true", "-p", &parameter];
    let error = startup_error(&nodes, "agent_node", &arguments);
    let reason = format!("there is no checkpoint.safetensors in {}", out.display());
    assert!(error.contains(&reason), "{error}");
    assert!(!out.exists(), "an empty directory is left");
}
