//! Checks that docs/reference agrees with the programs.
//!
//! `EVAC_WRITE_REFERENCE=1 cargo test --release --locked --package evac_tests --test reference`
//! writes the generated sections.

use std::{collections::BTreeSet, fmt::Write, fs, path::Path};

use evac_tests::{Nodes, binary, repository};
use serde_json::Value;

/// Compares the section of a page between `<!-- NAME: begin -->` and `<!-- NAME: end -->` with the
/// generated text. With `EVAC_WRITE_REFERENCE`, replaces it first.
fn assert_section(page: &str, name: &str, generated: &str) {
    let path = repository().join("docs/reference").join(page);
    if std::env::var_os("EVAC_WRITE_REFERENCE").is_some() {
        experiments::replace_section(&path, name, generated).expect("the page has the section");
    }
    let text = fs::read_to_string(&path).expect("the page");
    let (_, rest) = text.split_once(&format!("<!-- {name}: begin -->")).expect("a beginning");
    let (section, _) = rest.split_once(&format!("<!-- {name}: end -->")).expect("an end");
    assert!(
        section.trim() == generated.trim(),
        "section {name} of docs/reference/{page} is out of date: set EVAC_WRITE_REFERENCE=1 and \
         run this test again"
    );
}

/// Runs a program and returns what it prints.
fn printed(nodes: &Nodes, program: &str, arguments: &[&str]) -> String {
    let mut command = nodes.command(binary(program));
    // Help is wrapped to the width of the terminal.
    let (status, text, error) = nodes.run(command.args(arguments).env("COLUMNS", "100"));
    assert!(status.success(), "{program} {arguments:?}: {error}");
    text
}

/// Returns a table of the parameters that a node prints as JSON. `paper` is what it prints with preset
/// `paper`, or an empty list.
fn parameter_table(json: &str, paper: &str) -> String {
    let parse = |json: &str| -> Vec<Value> { serde_json::from_str(json).expect("parameters") };
    let (parameters, paper) = (parse(json), parse(paper));
    let mut table =
        "| parameter | type | default | valid | changes | description |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for parameter in parameters {
        let text = |key: &str| parameter[key].as_str().expect("a string").replace('|', "\\|");
        let choices: Vec<&str> = parameter["choices"]
            .as_array()
            .expect("choices")
            .iter()
            .filter_map(Value::as_str)
            .collect();
        let valid = match (&parameter["range"], choices.is_empty()) {
            (Value::Array(range), _) => {
                // The bounds are floats, even for an integer parameter.
                let bound = |value: &Value| value.to_string().trim_end_matches(".0").to_owned();
                format!("{} to {}", bound(&range[0]), bound(&range[1]))
            }
            (_, false) => choices.join(", "),
            _ => String::new(),
        };
        let changes = if parameter["read_only"] == true { "at start" } else { "at run time" };
        let code = |value: &Value| match value {
            Value::String(text) if text.is_empty() => String::new(),
            Value::String(text) => format!("`{text}`"),
            value => format!("`{value}`"),
        };
        let mut default = code(&parameter["default"]);
        let same = paper.iter().find(|other| other["name"] == parameter["name"]);
        if let Some(other) = same.filter(|other| other["default"] != parameter["default"]) {
            write!(default, "; preset `paper`: {}", code(&other["default"]))
                .expect("writing to a string succeeds");
        }
        let (name, kind, description) = (text("name"), text("expected"), text("description"));
        writeln!(table, "| `{name}` | {kind} | {default} | {valid} | {changes} | {description} |")
            .expect("writing to a string succeeds");
    }
    table
}

#[test]
fn parameters_are_documented() {
    let nodes = Nodes::new();
    for (section, program, arguments) in [
        ("sim_node", "sim_node", &["parameters"][..]),
        ("train", "agent_node", &["parameters", "train"]),
        ("evaluate", "agent_node", &["parameters", "evaluate"]),
        ("drive", "agent_node", &["parameters", "drive"]),
    ] {
        let with_paper = [arguments, &["--ros-args", "-p", "preset:=paper"]].concat();
        let paper = match section {
            "train" => printed(&nodes, program, &with_paper),
            _ => "[]".to_owned(),
        };
        let table = parameter_table(&printed(&nodes, program, arguments), &paper);
        assert_section("parameters.md", section, &table);
    }
}

#[test]
fn the_levels_of_randomization_are_documented() {
    let nodes = Nodes::new();
    let levels = ["none", "mild", "strong"].map(|level| -> Vec<Value> {
        let parameter = format!("randomization:={level}");
        let arguments = ["parameters", "--ros-args", "-p", &parameter];
        serde_json::from_str(&printed(&nodes, "sim_node", &arguments)).expect("a JSON list")
    });
    let mut table = "| parameter | `none` | `mild` | `strong` |\n|---|---|---|---|\n".to_owned();
    for (index, parameter) in levels[0].iter().enumerate() {
        let [none, mild, strong] = levels.each_ref().map(|level| &level[index]["value"]);
        if none != strong && parameter["name"] != "randomization" {
            let name = parameter["name"].as_str().expect("a name");
            writeln!(table, "| `{name}` | `{none}` | `{mild}` | `{strong}` |")
                .expect("writing to a string succeeds");
        }
    }
    assert_section("parameters.md", "levels", &table.replace('"', ""));
}

#[test]
fn commands_are_documented() {
    let nodes = Nodes::new();
    let fenced = |text: String| {
        let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
        format!("```text\n{}\n```", lines.join("\n").trim_end())
    };
    assert_section("commands.md", "evac", &fenced(printed(&nodes, "evac", &["--help"])));
    for command in ["train", "evaluate", "drive"] {
        let help = printed(&nodes, "evac", &[command, "--help"]);
        // The parameters have their own page.
        let (own, _) = help.split_once("Parameters of the agent:").expect("parameters");
        assert_section("commands.md", command, &fenced(own.to_owned()));
    }
}

#[test]
fn messages_and_services_are_documented() {
    let mut text = String::new();
    for kind in ["msg", "srv"] {
        let mut files: Vec<_> = fs::read_dir(repository().join("msgs").join(kind))
            .expect("the directory")
            .map(|entry| entry.expect("a file").path())
            .collect();
        files.sort();
        for file in files {
            let name = file.file_stem().expect("a name").to_string_lossy();
            let definition = fs::read_to_string(&file).expect("a definition");
            write!(text, "### evac_msgs/{kind}/{name}\n\n```text\n{}\n```\n\n", definition.trim())
                .expect("writing to a string succeeds");
        }
    }
    assert_section("interfaces.md", "definitions", &text);
}

/// Returns the names in the first column of the table below a heading.
fn listed(page: &str, heading: &str) -> BTreeSet<String> {
    let (_, rest) = page.split_once(heading).unwrap_or_else(|| panic!("no heading '{heading}'"));
    let rows = rest.lines().skip_while(|line| !line.starts_with('|'));
    let rows = rows.take_while(|line| line.starts_with('|')).skip(2);
    rows.flat_map(|row| {
        let cell = row.split('|').nth(1).expect("a first column");
        cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>()
    })
    .collect()
}

/// Returns the topics or services that an enclave of the SROS2 policy may use. The enclave's node
/// uses no others, because a secured node that did would not start.
fn permitted(policy: &str, enclave: &str, element: &str, access: &str) -> BTreeSet<String> {
    let (_, rest) = policy.split_once(&format!("<enclave path=\"{enclave}\"")).expect("enclave");
    let (enclave, _) = rest.split_once("</enclave>").expect("its end");
    let begin = format!("<{element}s {access}=\"ALLOW\">");
    let (_, rest) = enclave.split_once(&begin).unwrap_or_else(|| panic!("no {begin}"));
    let (list, _) = rest.split_once(&format!("</{element}s>")).expect("its end");
    let tag = format!("<{element}>");
    let names = list.split(&tag).skip(1).filter_map(|rest| rest.split('<').next());
    names.map(str::to_owned).collect()
}

#[test]
fn topics_and_services_are_those_of_the_security_policy() {
    let read = |path: &str| fs::read_to_string(repository().join(path)).expect("a page");
    let page = read("docs/reference/interfaces.md");
    let policy = read("launch_scripts/security/evac.policy.xml");
    for (heading, enclave, element, access) in [
        ("### Published by sim_node", "/evac/sim_node", "topic", "publish"),
        ("### Subscribed by sim_node", "/evac/sim_node", "topic", "subscribe"),
        ("### Served by sim_node", "/evac/sim_node", "service", "reply"),
        ("### Published by agent_node", "/evac/agent_node", "topic", "publish"),
        ("### Subscribed by agent_node", "/evac/agent_node", "topic", "subscribe"),
        ("### Called by agent_node", "/evac/agent_node", "service", "request"),
        ("### Served by agent_node", "/evac/agent_node", "service", "reply"),
    ] {
        assert_eq!(
            listed(&page, heading),
            permitted(&policy, enclave, element, access),
            "left: docs/reference/interfaces.md, right: evac.policy.xml: {heading}"
        );
    }
}

/// Collects the files below `directory`, by their paths relative to `base`.
fn files(directory: &Path, base: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => files(&path, base, found),
            false => {
                let path = path.strip_prefix(base).expect("below it").display().to_string();
                found.insert(path);
            }
        }
    }
}

#[test]
fn files_of_a_run_are_documented() {
    let nodes = Nodes::new();
    let out = nodes.path("run");
    let directory = out.to_str().expect("a UTF-8 path");
    let train = ["train", "--episodes", "3", "--evaluation-episodes", "5", "--out", directory];
    let short = ["--checkpoint-interval", "1", "--", "-p", "max_steps:=20"];
    printed(&nodes, "evac", &[&train[..], &short].concat());
    let page = fs::read_to_string(repository().join("docs/reference/files.md")).expect("the page");
    let evaluated = nodes.path("evaluated");
    let to = evaluated.to_str().expect("a UTF-8 path");
    printed(
        &nodes,
        "evac",
        &[
            &["evaluate", "--model", directory, "--episodes", "5", "--max-steps", "20"][..],
            &["--robustness", "--out", to],
        ]
        .concat(),
    );
    let mut found = BTreeSet::new();
    files(&evaluated, &evaluated, &mut found);
    let documented = listed(&page, "## Files of an evaluation");
    assert_eq!(documented, found, "left: files.md, right: an evaluation");
    found.clear();
    files(&out, &out, &mut found);
    // The names of TensorBoard's files contain the time and the host name.
    let found: BTreeSet<String> = found
        .into_iter()
        .map(|name| match name.starts_with("tensorboard/") {
            true => "tensorboard/".to_owned(),
            false => name,
        })
        .collect();
    assert_eq!(listed(&page, "## Files of a training run"), found, "left: files.md, right: a run");
}
