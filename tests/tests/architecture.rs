//! ARCHITECTURE.md is true: the crates, and what each stands on.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    process::Command,
};

use evac_tests::repository;
use serde_json::Value;

/// Where a crate is, and which crates of this workspace it stands on.
type Crates = BTreeMap<String, (String, BTreeSet<String>)>;

/// What cargo says.
fn found() -> Crates {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--no-deps", "--format-version", "1"])
        .current_dir(repository())
        .output()
        .expect("cargo runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let text = |value: &Value| value.as_str().expect("a text").to_owned();
    let names: BTreeSet<String> = packages.iter().map(|package| text(&package["name"])).collect();
    let root = repository().to_str().expect("Unicode");
    let described = packages.iter().map(|package| {
        let manifest = text(&package["manifest_path"]);
        let place = manifest.trim_start_matches(root).trim_start_matches('/');
        let place = place.trim_end_matches("/Cargo.toml").to_owned();
        let dependencies = package["dependencies"].as_array().expect("dependencies");
        let needed = dependencies.iter().filter(|dependency| dependency["kind"] != "dev");
        let needed = needed.map(|dependency| text(&dependency["name"]));
        let needed = needed.filter(|name| names.contains(name)).collect();
        (text(&package["name"]), (place, needed))
    });
    described.collect()
}

/// What the table says: | crate | where | what it is | stands on |.
fn told() -> Crates {
    let page = fs::read_to_string(repository().join("ARCHITECTURE.md")).expect("the page");
    let (_, table) = page.split_once("| crate | where |").expect("the table of crates");
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let names = |cell: &str| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect();
    let described = rows.map(|row| {
        let cells: Vec<&str> = row.split('|').collect();
        let name = cells[1].trim().trim_matches('`').to_owned();
        (name, (cells[2].trim().trim_matches('`').to_owned(), names(cells[4])))
    });
    described.collect()
}

#[test]
fn the_table_of_crates_is_that_of_cargo() {
    assert_eq!(told(), found(), "ARCHITECTURE.md left, cargo right");
}

#[test]
fn learner_and_report_know_no_ros_and_the_runtime_not_this_project() {
    let crates = found();
    let below = |name: &str| {
        let mut all = BTreeSet::from([name.to_owned()]);
        loop {
            let more: Vec<_> = all.iter().flat_map(|name| crates[name].1.clone()).collect();
            let count = all.len();
            all.extend(more);
            if all.len() == count {
                return all;
            }
        }
    };
    for name in ["task", "learning", "report"] {
        let ros = ["ros_runtime", "ros_interfaces", "evac_msgs"];
        assert!(ros.iter().all(|ros| !below(name).contains(*ros)), "{name}");
    }
    let runtime = below("ros_runtime");
    assert!(["task", "evac_msgs"].iter().all(|own| !runtime.contains(*own)), "{runtime:?}");
    let grep = Command::new("grep")
        .args(["--recursive", "--ignore-case", "--files-with-matches", "evac"])
        .arg(repository().join("crates/ros_runtime"))
        .output();
    let files = String::from_utf8(grep.expect("grep runs").stdout).expect("Unicode");
    assert_eq!(files, "", "ros_runtime speaks of this project");
}

/// Paths in the pages for developers and users: `crates/task/src/image.rs`.
#[test]
fn every_path_in_the_docs_exists() {
    let mut missing = Vec::new();
    let docs = fs::read_dir(repository().join("docs")).expect("the docs");
    let docs = docs.map(|entry| entry.expect("an entry").path());
    let pages = ["README.md", "ARCHITECTURE.md"].map(|name| repository().join(name));
    for page in docs.chain(pages).filter(|page| page.extension().is_some_and(|e| e == "md")) {
        let text = fs::read_to_string(&page).expect("a page");
        // What stands between the first and the second backtick, the third and the fourth, ...
        for word in text.split('`').skip(1).step_by(2) {
            let roots = ["agent_node/", "crates/", "docs/", "launch_scripts/", "msgs/", "patches/"];
            let roots = [&roots[..], &["sim_node/", "tests/"]].concat();
            let is_path = roots.iter().any(|root| word.starts_with(root))
                && word.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
            if is_path && !repository().join(word).exists() {
                missing.push(format!("{}: {word}", page.display()));
            }
        }
    }
    assert_eq!(missing, Vec::<String>::new());
}
