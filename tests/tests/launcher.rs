//! `evac`: options, errors before anything starts, and nothing left behind.

use evac_tests::{
    Nodes, binary,
    launcher::{Kill, assert_leaves_nothing},
};

fn evac(arguments: &[&str]) -> (bool, String, String) {
    let nodes = Nodes::new();
    let (status, text, error) = nodes.run(nodes.command(binary("evac")).args(arguments));
    (status.success(), text, error)
}

#[test]
fn killed_in_any_way_it_leaves_no_process_and_the_training_goes_on() {
    assert_leaves_nothing(Kill::Alone("KILL"), 2);
    assert_leaves_nothing(Kill::Alone("TERM"), 2);
    assert_leaves_nothing(Kill::Alone("HUP"), 2);
    assert_leaves_nothing(Kill::Group("INT"), 2);
}

#[test]
fn help_has_every_parameter_with_its_default_and_choices() {
    let (_, help, _) = evac(&["train", "--help"]);
    for expected in [
        "--episodes <N>",
        "training episodes [1 to 1000000] [default: 3000]",
        "[default: robust] [possible values: paper, robust]",
        "--step-duration <X>",
    ] {
        assert!(help.contains(expected), "{expected} is not in {help}");
    }
    let (succeeds, completions, _) = evac(&["completions", "bash"]);
    assert!(succeeds && completions.contains("--evaluation-episodes"), "{completions}");
}

#[test]
fn what_is_wrong_is_told_before_anything_starts() {
    for (arguments, expected) in [
        (
            &["train", "--episodes", "abc"][..],
            "'episodes' is the string 'abc': expected an integer",
        ),
        (&["train", "--episodes", "0"], "'episodes' is the integer 0: expected 1 to 1000000"),
        (
            &["train", "--batch-size", "60000"],
            "'batch_size' is 60000: expected at most memory_capacity",
        ),
        (&["train", "--step-duration", "0"], "'step_duration' is the number 0: expected"),
        (&["train", "--", "-p", "nonsense:=1"], "no parameter 'nonsense': this node has"),
        // As `ros2 launch` ends them.
        (&["train", "--episodes", "0", "--ros-args"], "'episodes' is the integer 0"),
        (&["train", "--ros-args", "-p", "nonsense:=1"], "no parameter 'nonsense': this node has"),
        (&["drive"], "which model? give --model DIR"),
        (&["evaluate", "--model", "/nowhere"], "no trained model in /nowhere"),
    ] {
        let (succeeds, _, error) = evac(arguments);
        assert!(!succeeds && error.contains(expected), "{arguments:?}: {error}");
        assert!(!error.contains("[INFO]"), "a node has started: {error}");
    }
}
