//! Runs the scripts in `launch_scripts` as a user does.

use std::{
    fs,
    os::unix::process::CommandExt,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use evac_tests::{Nodes, Outcome, TIMEOUT, binary, repository};
use learning::{settings::Preset, training::Plan};
use sim_node::world::WorldSettings;

#[test]
fn train_evaluate_and_drive_work_and_reject_invalid_options() {
    let nodes = Nodes::new();
    // Builds the nodes with the profile of this test. If it is release, the scripts need not build.
    binary("agent_node");
    let out = nodes.path("run");
    let script = |name: &str, arguments: &[&str]| {
        let script = repository().join("launch_scripts").join(name);
        let (status, _, text) = nodes.run(nodes.command(script).args(arguments));
        (status, text)
    };
    let directory = out.to_str().expect("a UTF-8 path");
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
        "figures/learning_curve.svg",
        "figures/paths.svg",
        "figures/states.svg",
        "figures/rooms.svg",
        "figures/escape.gif",
    ] {
        assert!(out.join(name).exists(), "{name} is missing");
    }
    let json = |name: &str| -> serde_json::Value {
        let text = fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        serde_json::from_str(&text).expect("JSON")
    };
    let report = fs::read_to_string(out.join("report.html")).expect("report.html");
    assert!(report.contains("Escapes from the same room"), "no figures in the report");
    let shortest_path = json("summary.json")["evaluation"]["oracle_mean_steps"].as_f64();
    assert!((8.0..11.0).contains(&shortest_path.expect("a number")), "{shortest_path:?}");

    let options = ["--model", directory, "--episodes", "20", "--seed", "9", "--max-steps", "10"];
    let (status, text) = script("evaluate.sh", &options);
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

    // Runs until Ctrl-C, which a terminal sends to the process group.
    let mut drive = nodes.command(repository().join("launch_scripts/drive.sh"));
    let log = nodes.path("drive.log");
    drive.process_group(0).args(["--model", directory, "--motion-time", "0.02"]);
    let file = fs::File::create(&log).expect("a log");
    let mut child = drive.stderr(file).spawn().expect("the script runs");
    let text = || fs::read_to_string(&log).unwrap_or_default();
    let end = Instant::now() + TIMEOUT;
    while !text().contains("receiving images") {
        assert!(Instant::now() < end, "{}", text());
        std::thread::sleep(Duration::from_millis(20));
    }
    let group = format!("-{}", child.id());
    assert!(
        Command::new("kill")
            .args(["-s", "INT", "--", &group])
            .status()
            .expect("kill runs")
            .success()
    );
    assert_eq!(child.wait().expect("a child process").code(), Some(0), "{}", text());
    assert!(text().contains("images, sent"), "{}", text());

    for (name, arguments, expected) in [
        ("train.sh", &["--nonsense"][..], "unexpected argument '--nonsense'"),
        ("train.sh", &["--seed"], "a value is required for '--seed"),
        ("train.sh", &["--preset", "nonsense"], "possible values: paper, robust"),
        ("train.sh", &["--episodes", "abc"], "'episodes' is the string 'abc': expected an integer"),
        ("drive.sh", &["--model", "/nowhere"], "no trained model in /nowhere"),
        ("evaluate.sh", &[], "missing option --model DIR"),
        ("evaluate.sh", &["--model", "/nowhere"], "no trained model in /nowhere"),
    ] {
        let (status, text) = script(name, arguments);
        assert!(!status.success() && text.contains(expected), "{name} {arguments:?}: {text}");
    }
}

/// Returns the ID of a process with this name in a process group; `None` if there is none.
/// A process killed a moment ago is still in /proc: `killed` names those to leave out.
fn find_process(name: &str, group: u32, killed: &[String]) -> Option<String> {
    let processes = fs::read_dir("/proc").expect("/proc is mounted").map_while(Result::ok);
    let mut ids = processes.map(|entry| entry.file_name().to_string_lossy().into_owned());
    ids.find(|id| {
        if killed.contains(id) {
            return false;
        }
        // proc_pid_stat(5): pid (comm) state ppid pgrp ...
        let stat = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        let group = group.to_string();
        stat.contains(&format!("({name})")) && stat.split(' ').nth(4) == Some(group.as_str())
    })
}

#[test]
fn a_node_that_fails_is_restarted_and_the_training_continues() {
    let nodes = Nodes::new();
    binary("agent_node");
    let out = nodes.path("run");
    let log = nodes.path("train.log");
    let text = || fs::read_to_string(&log).unwrap_or_default();
    let mut train = nodes.command(repository().join("launch_scripts/train.sh"));
    train.process_group(0).args(["--preset", "paper", "--scenario", "empty", "--episodes", "300"]);
    train.args(["--seed", "7", "--evaluation-episodes", "0"]).arg("--out").arg(&out);
    train.args(["--", "-p", "checkpoint_interval:=10"]);
    let mut child = train.stderr(fs::File::create(&log).expect("a log")).spawn().expect("a script");
    let end = Instant::now() + 5 * TIMEOUT;
    let mut killed = Vec::new();
    // The agent fails once alone, and once while the simulator is being restarted.
    for name in ["agent_node", "sim_node", "agent_node"] {
        let process = loop {
            let process = find_process(name, child.id(), &killed);
            match process.filter(|_| out.join("checkpoint.safetensors").exists()) {
                Some(process) => break process,
                None => assert!(Instant::now() < end, "{}", text()),
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let kill = Command::new("kill").args(["-s", "ABRT", &process]).status();
        assert!(kill.expect("kill runs").success());
        killed.push(process);
    }
    assert!(child.wait().expect("a child process").success(), "{}", text());
    for expected in [
        "agent_node crashed; restarting it (1 of at most 3 restarts)",
        "agent_node crashed; restarting it (2 of at most 3 restarts)",
        "resuming after",
        "sim_node exited with signal: 6 (SIGABRT)",
    ] {
        assert!(text().contains(expected), "{expected}: {}", text());
    }
    assert_eq!(text().matches("sim_node exited").count(), 1, "{}", text());
    let plan = Plan { scenario: "empty".to_owned(), episodes: 300, seed: 7, rooms: 1 };
    let max_steps = WorldSettings::default().max_steps;
    let undisturbed = Outcome::in_process(plan, Preset::Paper, max_steps, &nodes.path("here"));
    Outcome::read_from(&out).assert_identical(&undisturbed);
}

/// An earlier bar would overwrite the lines below it.
#[test]
fn on_a_narrow_terminal_the_progress_bar_of_training_ends_before_the_evaluation() {
    let nodes = Nodes::new();
    binary("agent_node");
    let train = repository().join("launch_scripts/train.sh");
    let train = format!(
        "stty cols 80; exec '{}' --episodes 60 --evaluation-episodes 60 --max-steps 20 --out '{}'",
        train.display(),
        nodes.path("run").display()
    );
    let (status, text, _) = nodes.run(nodes.command("script").args(["-qec", &train, "/dev/null"]));
    assert!(status.success(), "{text}");
    let (training, evaluation) =
        text.split_once("evaluation 0/60").expect("the bar of the evaluation");
    assert!(training.contains("training 60/60"), "{training}");
    assert!(!evaluation.contains("training 60/60"), "{evaluation}");
    assert!(evaluation.contains("results written to"), "{evaluation}");
}

#[test]
fn ctrl_c_in_a_terminal_saves_the_training_and_leaves_no_process() {
    let nodes = Nodes::new();
    binary("agent_node");
    let home = nodes.path("it's home");
    fs::create_dir(&home).expect("a directory");
    let out = home.join("run");
    let temporary = nodes.path("temporary");
    fs::create_dir(&temporary).expect("a directory");
    // A terminal runs each command in its own process group.
    let mut train = nodes.command(repository().join("launch_scripts/train.sh"));
    train
        .process_group(0)
        .env("TMPDIR", &temporary)
        .args(["--preset", "paper", "--episodes", "100000", "--out"])
        .arg(&out);
    let log = nodes.path("train.log");
    let file = fs::File::create(&log).expect("a log");
    let mut child = train.stderr(file).spawn().expect("the script runs");
    let end = Instant::now() + 5 * TIMEOUT;
    let text = || fs::read_to_string(&log).unwrap_or_default();
    // Progress is first logged after 50 episodes; then there is something to save.
    while !text().contains("training 50/") {
        assert!(Instant::now() < end, "{}", text());
        assert!(child.try_wait().expect("a child process").is_none(), "{}", text());
        std::thread::sleep(Duration::from_millis(20));
    }
    let group = format!("-{}", child.id());
    let signal = |name: &str| {
        let kill =
            Command::new("kill").args(["-s", name, "--", &group]).stderr(Stdio::null()).status();
        kill.expect("kill runs").success()
    };
    assert!(signal("INT"));
    let status = child.wait().expect("a child process");
    assert_eq!(status.code(), Some(0), "{}", text());
    assert!(text().contains("run the same command with --resume to continue"), "{}", text());
    assert!(out.join("checkpoint.safetensors").exists());
    assert_eq!(fs::read_dir(&temporary).expect("the directory exists").count(), 0);
    // Signal 0 only checks whether the process group still exists.
    assert!(!signal("0"), "a process is still running:\n{}", text());
}
