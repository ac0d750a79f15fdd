//! Checks the commands in README.md and docs/tutorial.md: runs each as printed there, with added
//! options that shorten it. A long test runs the tutorial's commands unchanged and compares their
//! output with the page.

use std::{
    fs,
    os::unix::process::CommandExt,
    process::Command,
    time::{Duration, Instant},
};

use evac_tests::{Nodes, TIMEOUT, repository};

/// How to check a command on a page.
enum Run {
    /// Run it with these arguments appended; it must succeed.
    With(&'static str),
    /// Run it with these arguments appended until its log contains this text, then send SIGINT; it
    /// must succeed.
    Until(&'static str, &'static str),
    /// Do not run it; the text states why, or where it is tested.
    Elsewhere(&'static str),
}

/// The check for each command on the pages. A command is identified by its prefix.
const COMMANDS: &[(&str, Run)] = &[
    ("launch_scripts/train.sh", Run::With("--episodes 4 --evaluation-episodes 3 --max-steps 30")),
    ("launch_scripts/evaluate.sh", Run::With("--episodes 3 --max-steps 30")),
    ("launch_scripts/drive.sh --model runs/mixed-robust-seed0 --robot", Run::Until("", "waiting")),
    ("launch_scripts/drive.sh", Run::Until("--motion-time 0.02", "receiving images")),
    ("launch_scripts/build.sh", Run::With("")),
    ("launch_scripts/setup.sh", Run::With("")),
    ("launch_scripts/test.sh", Run::Elsewhere("it runs this test")),
    ("head", Run::With("")),
    ("ls", Run::With("")),
    ("target/release/agent_node", Run::With("")),
    ("target/release/sim_node", Run::Until("", "simulator ready")),
    ("export ROS_AUTOMATIC_DISCOVERY_RANGE", Run::Elsewhere("a setting for the commands below it")),
    ("ros2", Run::Elsewhere("tests/tests/ros2.rs, with ROS 2")),
    ("git clone", Run::Elsewhere("CI works on a clone")),
    ("cd ", Run::Elsewhere("the test knows the directory")),
];

/// Returns the commands in a page's shell blocks, without comments.
fn commands(page: &str) -> Vec<String> {
    let mut commands = Vec::new();
    for block in page.split("```sh\n").skip(1) {
        let (block, _) = block.split_once("```").expect("the end of a block");
        for line in block.lines() {
            let command = line.split(" #").next().unwrap_or_default().trim();
            if !command.is_empty() && !command.starts_with('#') {
                commands.push(command.to_owned());
            }
        }
    }
    commands
}

#[test]
fn the_commands_in_readme_and_tutorial_work() {
    for page in ["README.md", "docs/tutorial.md"] {
        let nodes = Nodes::new();
        let text = fs::read_to_string(repository().join(page)).expect("a page");
        let commands = commands(&text);
        assert!(commands.len() > 5, "{page} has too few commands");
        for command in commands {
            let known = COMMANDS.iter().find(|(beginning, _)| command.starts_with(beginning));
            let (_, run) = known.unwrap_or_else(|| panic!("{page}: `{command}` is not tested"));
            match run {
                Run::With(more) => {
                    let (status, _, log) = nodes.run(&mut shell(&nodes, &command, more));
                    assert!(status.success(), "{page}: `{command} {more}`: {log}");
                }
                Run::Until(more, expected) => run_until(&nodes, &command, more, expected),
                Run::Elsewhere(place) => println!("{page}: `{command}`: {place}"),
            }
        }
    }
}

/// Splits a page into its shell commands and the lines of output shown below them.
fn commands_and_output(page: &str) -> Vec<(String, Vec<String>)> {
    let mut pairs: Vec<(String, Vec<String>)> = Vec::new();
    // The command whose output comes next: blocks of output follow the block of their commands.
    let mut next = 0;
    for block in page.split("```").skip(1).step_by(2) {
        match block.split_once('\n').expect("the language of a block") {
            ("sh", _) => {
                next = pairs.len();
                let commands = commands(&format!("```{block}```"));
                pairs.extend(commands.into_iter().map(|command| (command, Vec::new())));
            }
            ("text", output) => {
                let (_, lines) = pairs.get_mut(next).expect("a command above the output");
                lines.extend(output.lines().map(str::to_owned));
                next += 1;
            }
            (language, _) => panic!("a block in the language '{language}'"),
        }
    }
    pairs
}

/// Keys of `summary.json` that depend on the machine.
const TIMING: [&str; 3] = ["wall_s", "steps_per_s", "update_us"];

#[test]
#[ignore = "trains three policies, which takes a few minutes"]
fn the_tutorial_shows_the_output_of_its_commands() {
    let page = fs::read_to_string(repository().join("docs/tutorial.md")).expect("a page");
    let nodes = Nodes::new();
    let mut compared = 0;
    for (command, expected) in commands_and_output(&page) {
        if expected.is_empty() || command.starts_with("launch_scripts/drive.sh") {
            continue;
        }
        let (status, output, log) = nodes.run(&mut shell(&nodes, &command, ""));
        assert!(status.success(), "`{command}`: {log}");
        for line in expected {
            if TIMING.iter().any(|key| line.contains(key)) {
                continue;
            }
            let text = line.replace("[INFO] [...] ", "");
            let found = match command.starts_with("ls ") {
                true => text.split_whitespace().all(|name| output.lines().any(|line| line == name)),
                false => output.lines().chain(log.lines()).any(|line| line.ends_with(&text)),
            };
            assert!(found, "`{command}`: '{text}' is not in its output:\n{output}{log}");
            compared += 1;
        }
    }
    assert!(compared > 20, "only {compared} lines compared");
}

/// Returns a shell that runs a command from a page in the directory of `nodes`, with the programs
/// of the repository.
fn shell(nodes: &Nodes, command: &str, more: &str) -> Command {
    let root = repository().display().to_string();
    let target = evac_tests::binary("evac");
    let target = target.parent().expect("a directory").display().to_string();
    let command = command
        .replace("launch_scripts/", &format!("{root}/launch_scripts/"))
        .replace("target/release/", &format!("{target}/"));
    let mut shell = nodes.command("bash");
    shell.args(["-c", &format!("exec {command} {more}")]).current_dir(nodes.path(""));
    shell
}

fn run_until(nodes: &Nodes, command: &str, more: &str, expected: &str) {
    let log = nodes.path("log");
    let file = fs::File::create(&log).expect("a log");
    let mut shell = shell(nodes, command, more);
    shell.process_group(0).stdout(file.try_clone().expect("a file")).stderr(file);
    let mut child = shell.spawn().expect("bash runs");
    let text = || fs::read_to_string(&log).unwrap_or_default();
    let end = Instant::now() + TIMEOUT;
    while !text().contains(expected) {
        let ended = child.try_wait().expect("it is our child");
        assert!(ended.is_none() && Instant::now() < end, "`{command} {more}`: {}", text());
        std::thread::sleep(Duration::from_millis(20));
    }
    let group = format!("-{}", child.id());
    let status = Command::new("kill").args(["-s", "INT", "--", &group]).status();
    assert!(status.expect("kill runs").success());
    let status = child.wait().expect("it is our child");
    assert_eq!(status.code(), Some(0), "`{command} {more}`: {}", text());
}
