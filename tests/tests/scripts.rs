//! The scripts, as a newcomer runs them.

use std::fs;

use evac_tests::{Nodes, binary, repository};

#[test]
fn train_and_evaluate_leave_their_files() {
    let nodes = Nodes::new();
    // Builds the nodes in this profile; the scripts then find them built if it is theirs.
    binary("agent_node");
    let out = nodes.path("run");
    let script = |name: &str, arguments: &[&str]| {
        let script = repository().join("launch_scripts").join(name);
        let (status, _, text) = nodes.run(nodes.command(script).args(arguments));
        (status, text)
    };
    let directory = out.to_str().expect("a path in Unicode");
    let options =
        ["--episodes", "3", "--seed", "4", "--scenario", "one_cylinder", "--out", directory];
    let short = ["--", "-p", "epsilon_min:=1.0", "-p", "max_steps:=10"];
    let (status, text) = script("train.sh", &[&options[..], &short].concat());
    assert!(status.success(), "{text}");
    for name in [
        "summary.json",
        "config.yaml",
        "episodes.csv",
        "model.safetensors",
        "checkpoint.safetensors",
        "report.html",
    ] {
        assert!(out.join(name).exists(), "{name} is missing");
    }
    let json = |name: &str| -> serde_json::Value {
        let text = fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        serde_json::from_str(&text).expect("JSON")
    };
    let fewest = json("summary.json")["evaluation"]["oracle_mean_steps"].as_f64();
    assert!((8.0..11.0).contains(&fewest.expect("the oracle's number")), "{fewest:?}");

    let test = ["--model", directory, "--episodes", "20", "--seed", "9", "--max-steps", "10"];
    let (status, text) = script("evaluate.sh", &test);
    assert!(status.success(), "{text}");
    let evaluation = json("evaluation.json");
    assert_eq!(
        (&evaluation["episodes"], &evaluation["scenario"]),
        (&20.into(), &"one_cylinder".into())
    );
    for key in [
        "successes",
        "success_rate",
        "mean_steps",
        "oracle_mean_steps",
        "optimality_ratio",
        "blocked_per_100_steps",
        "collision_free_rate",
    ] {
        assert!(evaluation.get(key).is_some(), "{key} is missing");
    }

    for (name, arguments, expected) in [
        ("train.sh", &["--nonsense"][..], "unknown option '--nonsense'"),
        ("train.sh", &["--seed"], "--seed needs a value"),
        ("train.sh", &["--preset", "nonsense"], "expected one of paper"),
        ("evaluate.sh", &[], "which model?"),
        ("evaluate.sh", &["--model", "/nowhere"], "no trained model in /nowhere"),
    ] {
        let (status, text) = script(name, arguments);
        assert!(!status.success() && text.contains(expected), "{name} {arguments:?}: {text}");
    }
}
