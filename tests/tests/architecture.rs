//! Checks ARCHITECTURE.md and the dependencies between crates, and that paths in the docs exist.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    process::Command,
};

use evac_tests::repository;
use serde_json::Value;

/// The directory of each crate and its dependencies within the workspace, by the crate's name.
type Crates = BTreeMap<String, (String, BTreeSet<String>)>;

/// Returns the crates as `cargo metadata` reports them, without dev-dependencies.
fn cargo_crates() -> Crates {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--no-deps", "--format-version", "1"])
        .current_dir(repository())
        .output()
        .expect("cargo runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let text = |value: &Value| value.as_str().expect("a string").to_owned();
    let names: BTreeSet<String> = packages.iter().map(|package| text(&package["name"])).collect();
    let root = repository().to_str().expect("Unicode");
    let crates = packages.iter().map(|package| {
        let manifest = text(&package["manifest_path"]);
        let directory = manifest.trim_start_matches(root).trim_start_matches('/');
        let directory = directory.trim_end_matches("/Cargo.toml").to_owned();
        let dependencies = package["dependencies"].as_array().expect("dependencies");
        let dependencies = dependencies.iter().filter(|dependency| dependency["kind"] != "dev");
        let dependencies = dependencies.map(|dependency| text(&dependency["name"]));
        let dependencies = dependencies.filter(|name| names.contains(name)).collect();
        (text(&package["name"]), (directory, dependencies))
    });
    crates.collect()
}

/// Returns the crates in the first table of ARCHITECTURE.md, whose columns are name, directory,
/// description and dependencies.
fn documented_crates() -> Crates {
    let page = fs::read_to_string(repository().join("ARCHITECTURE.md")).expect("the page");
    let (_, table) = page.split_once("| crate | where |").expect("the table of crates");
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let names = |cell: &str| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect();
    let crates = rows.map(|row| {
        let cells: Vec<&str> = row.split('|').collect();
        let name = cells[1].trim().trim_matches('`').to_owned();
        (name, (cells[2].trim().trim_matches('`').to_owned(), names(cells[4])))
    });
    crates.collect()
}

#[test]
fn architecture_md_lists_the_crates_and_their_dependencies() {
    assert_eq!(documented_crates(), cargo_crates(), "left: ARCHITECTURE.md, right: cargo");
}

#[test]
fn learning_and_report_are_free_of_ros_and_ros_runtime_is_free_of_evac() {
    let crates = cargo_crates();
    let transitive_dependencies = |name: &str| {
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
        let dependencies = transitive_dependencies(name);
        assert!(ros.iter().all(|ros| !dependencies.contains(*ros)), "{name}");
    }
    let runtime = transitive_dependencies("ros_runtime");
    assert!(["task", "evac_msgs"].iter().all(|own| !runtime.contains(*own)), "{runtime:?}");
    let grep = Command::new("grep")
        .args(["--recursive", "--ignore-case", "--files-with-matches", "evac"])
        .arg(repository().join("crates/ros_runtime"))
        .output();
    let files = String::from_utf8(grep.expect("grep runs").stdout).expect("Unicode");
    assert_eq!(files, "", "ros_runtime mentions Evac");
}

/// Checks paths in backticks, such as `crates/task/src/image.rs`.
#[test]
fn every_path_in_the_docs_exists() {
    let mut missing = Vec::new();
    let docs = fs::read_dir(repository().join("docs")).expect("the docs");
    let docs = docs.map(|entry| entry.expect("an entry").path());
    let pages = ["README.md", "ARCHITECTURE.md"].map(|name| repository().join(name));
    for page in docs.chain(pages).filter(|page| page.extension().is_some_and(|e| e == "md")) {
        let text = fs::read_to_string(&page).expect("a page");
        // Every second part of the text is between backticks.
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

#[test]
fn ros_packages_have_the_version_of_cargo_toml() {
    for package in ["agent_node", "launch_scripts", "msgs", "sim_node"] {
        let path = repository().join(package).join("package.xml");
        let text = fs::read_to_string(&path).expect("a package.xml");
        let expected = format!("<version>{}</version>", env!("CARGO_PKG_VERSION"));
        assert!(text.contains(&expected), "{package}: run launch_scripts/version.sh");
    }
}
