//! Checks `evac`: its options, its errors before any node starts, and that it leaves no process
//! behind.

use evac_tests::{
    Nodes, binary,
    launcher::{Kill, assert_leaves_nothing},
};

fn evac(arguments: &[&str]) -> (bool, String, String) {
    let nodes = Nodes::new();
    let (status, text, error) = nodes.run(
        // An option that is accepted by mistake must not start a run in the repository.
        nodes.command(binary("evac")).args(arguments).current_dir(nodes.path("")),
    );
    (status.success(), text, error)
}

#[test]
fn evac_killed_by_any_signal_leaves_no_process_and_training_can_be_resumed() {
    assert_leaves_nothing(Kill::Alone("KILL"), 2);
    assert_leaves_nothing(Kill::Alone("TERM"), 2);
    assert_leaves_nothing(Kill::Alone("HUP"), 2);
    assert_leaves_nothing(Kill::Group("INT"), 2);
}

#[test]
fn help_lists_parameters_with_defaults_and_choices() {
    let (_, help, _) = evac(&["train", "--help"]);
    // The lines are wrapped at the width of the terminal.
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for expected in [
        "--episodes <N>",
        "number of training episodes [1 to 1000000] [default: 9000]",
        "[default: robust] [possible values: paper, robust]",
        "--step-duration <X>",
    ] {
        assert!(help.contains(expected), "{expected} is not in {help}");
    }
    let (succeeds, completions, _) = evac(&["completions", "bash"]);
    assert!(succeeds && completions.contains("--evaluation-episodes"), "{completions}");
}

#[test]
fn rejects_invalid_options_before_any_node_starts() {
    for (arguments, expected) in [
        (
            &["train", "--episodes", "abc"][..],
            "'episodes' is the string 'abc': expected an integer",
        ),
        (&["train", "--episodes", "0"], "'episodes' is the integer 0: expected 1 to 1000000"),
        (
            &["train", "--batch-size", "60", "--memory-capacity", "50"],
            "'batch_size' is 60: expected at most memory_capacity, 50",
        ),
        (&["train", "--step-duration", "0"], "'step_duration' is the number 0: expected"),
        (&["train", "--", "-p", "nonsense:=1"], "unknown parameter 'nonsense' (expected: "),
        // The arguments that `ros2 launch` appends.
        (&["train", "--episodes", "0", "--ros-args"], "'episodes' is the integer 0"),
        (&["train", "--ros-args", "-p", "nonsense:=1"], "unknown parameter 'nonsense' (expected: "),
        (&["drive"], "missing option --model DIR"),
        (&["evaluate", "--model", "/nowhere"], "no trained model in /nowhere"),
    ] {
        let (succeeds, _, error) = evac(arguments);
        assert!(!succeeds && error.contains(expected), "{arguments:?}: {error}");
        assert!(!error.contains("[INFO]"), "a node has started: {error}");
    }
}
