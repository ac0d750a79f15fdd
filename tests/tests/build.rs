//! The build: one RustDDS for every selection of packages, and the corrections that setup.sh applies.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use evac_tests::repository;

/// What cargo prints, which must succeed.
fn cargo(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(repository())
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The features of each package that RustDDS and ros2-client stand on, for a selection of packages. A
/// package that is also built for procedural macros has two sets.
fn features(of: &BTreeSet<String>, selection: &str) -> BTreeMap<String, BTreeSet<String>> {
    let tree = ["tree", "--locked", "--prefix", "none", "--format", "{p}|{f}"];
    let arguments: Vec<&str> = tree.into_iter().chain(selection.split(' ')).collect();
    let mut features: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in cargo(&arguments).lines() {
        let Some((package, enabled)) = line.split_once('|') else { continue };
        let name = package.split(' ').take(2).collect::<Vec<_>>().join(" ");
        if of.contains(&name) {
            let enabled = enabled.trim_end_matches(" (*)").to_owned();
            features.entry(name).or_default().insert(enabled);
        }
    }
    features
}

/// Otherwise a `cargo test` of one package builds RustDDS anew, and the next script does it again.
#[test]
fn every_selection_builds_rustdds_with_the_same_features() {
    let tree = cargo(&["tree", "--locked", "--prefix", "none", "--package", "ros2-client"]);
    let names = tree.lines().filter(|line| !line.is_empty());
    let names = names.map(|line| line.split(' ').take(2).collect::<Vec<_>>().join(" "));
    let names: BTreeSet<String> = names.collect();
    assert!(names.iter().any(|name| name.starts_with("rustdds ")), "{names:?}");

    let nodes = features(&names, "--package sim_node --package agent_node --edges normal,build");
    for selection in [
        "--workspace --edges normal,build",
        "--workspace --edges normal,build,dev",
        "--package evac_msgs --edges normal,build,dev",
        "--package ros_runtime --edges normal,build,dev",
        "--package sim_node --edges normal,build,dev",
        "--package agent_node --edges normal,build,dev",
        "--package evac_tests --edges normal,build,dev",
        "--package experiments --features programs --edges normal,build",
    ] {
        for (package, found) in features(&names, selection) {
            // A package that the nodes need for procedural macros, too, has a second set of features,
            // which a selection without those macros lacks.
            let expected = nodes.get(&package).expect("the nodes stand on it, too");
            assert!(
                found.is_subset(expected),
                "{selection}: {package} has {found:?}, not {expected:?}: add the features to \
                 crates/workspace_features/Cargo.toml"
            );
        }
    }
}

/// The oldest Rust that Cargo.toml promises is enough for every dependency; clippy's `incompatible_msrv`
/// checks the same for our own use of std.
#[test]
fn no_dependency_needs_a_newer_rust_than_we_promise() {
    let number = |version: &str| -> (u32, u32) {
        let mut parts = version.split('.').map(|part| part.parse().expect("a number"));
        (parts.next().expect("major"), parts.next().expect("minor"))
    };
    let metadata = cargo(&["metadata", "--locked", "--format-version", "1"]);
    let metadata: serde_json::Value = serde_json::from_str(&metadata).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let needed = |package: &serde_json::Value| package["rust_version"].as_str().map(number);
    let name = |package: &serde_json::Value| package["name"].as_str().map(str::to_owned);
    let own = packages.iter().find(|package| package["name"] == "evac_tests").and_then(needed);
    let newer = packages.iter().filter(|package| needed(package) > own).filter_map(name);
    assert_eq!(newer.collect::<Vec<_>>(), Vec::<String>::new(), "we promise {own:?}");
    assert!(packages.iter().filter_map(needed).count() > 100, "packages say what they need");
}

/// A copy of what setup.sh needs of the repository: no build, no `.cargo/corrected`.
struct Copy {
    directory: tempfile::TempDir,
}

impl Copy {
    fn new() -> Copy {
        let directory = tempfile::tempdir().expect("a directory");
        copy_sources(repository(), directory.path());
        Copy { directory }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn setup(&self) -> Command {
        let mut setup = Command::new(self.path("launch_scripts/setup.sh"));
        // Which the core tests are also run with.
        setup.env_remove("EVAC_UNCORRECTED");
        setup
    }

    fn set_up(&self) {
        let output = self.setup().output().expect("setup.sh runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    /// The corrected crate, as cargo finds it.
    fn corrected(&self) -> PathBuf {
        let text =
            fs::read_to_string(self.path(".cargo/corrected/config.toml")).expect("a configuration");
        let path = text.split('"').nth(1).expect("a path in quotation marks");
        self.path(".cargo").join(path)
    }

    fn corrections(&self) -> Vec<String> {
        let text = fs::read_to_string(self.corrected().join("CORRECTIONS")).expect("a list");
        text.lines().map(str::to_owned).collect()
    }
}

/// Copies manifests, sources and scripts; leaves out what is built or hidden, but for `.cargo/config.toml`.
fn copy_sources(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a directory");
    for entry in fs::read_dir(from).expect("a directory").map(|entry| entry.expect("an entry")) {
        let name = entry.file_name();
        let target = to.join(&name);
        match name.to_str().expect("a name in Unicode") {
            "target" | "runs" | "results" | "docs" => {}
            ".cargo" => {
                fs::create_dir(&target).expect("a directory");
                fs::copy(entry.path().join("config.toml"), target.join("config.toml"))
                    .expect("a copy");
            }
            hidden if hidden.starts_with('.') => {}
            _ if entry.file_type().expect("a type").is_dir() => {
                copy_sources(&entry.path(), &target)
            }
            _ => {
                fs::copy(entry.path(), target).expect("a copy");
            }
        }
    }
}

/// The names of the patches, in their order.
fn patches(directory: &Path) -> Vec<String> {
    let files = fs::read_dir(directory.join("patches/rustdds")).expect("the patches");
    let names = files.map(|file| file.expect("a file").file_name().into_string().expect("Unicode"));
    let mut names: Vec<String> =
        names.filter_map(|name| name.strip_suffix(".patch").map(str::to_owned)).collect();
    names.sort();
    names
}

#[test]
fn setup_corrects_rustdds_once_and_anew_when_a_patch_changes() {
    let copy = Copy::new();
    let all = patches(repository());
    // Two at once do no harm.
    let both: Vec<_> = (0..2).map(|_| copy.setup().spawn().expect("setup.sh runs")).collect();
    for mut one in both {
        assert!(one.wait().expect("it is our child").success());
    }
    assert_eq!(copy.corrections(), all);
    let metadata = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .current_dir(copy.path("sim_node"))
        .output()
        .expect("cargo runs");
    let metadata = String::from_utf8(metadata.stdout).expect("JSON");
    assert!(metadata.contains(copy.corrected().to_str().expect("Unicode")), "cargo builds with it");

    // Up to date: nothing is written.
    let written = |path: PathBuf| fs::metadata(path).expect("a file").modified().expect("a time");
    let before = written(copy.path(".cargo/corrected/config.toml"));
    copy.set_up();
    assert_eq!(written(copy.path(".cargo/corrected/config.toml")), before);

    // Each patch can be left out: the others apply all the same.
    let kept = tempfile::tempdir().expect("a directory");
    for dropped in &all {
        let file = copy.path("patches/rustdds").join(format!("{dropped}.patch"));
        fs::rename(&file, kept.path().join("patch")).expect("a file moves");
        copy.set_up();
        let others: Vec<String> = all.iter().filter(|name| *name != dropped).cloned().collect();
        assert_eq!(copy.corrections(), others);
        fs::rename(kept.path().join("patch"), &file).expect("a file moves");
    }
    // A correction is known by the name of its file.
    let file = copy.path("patches/rustdds").join(format!("{}.patch", all[0]));
    fs::rename(&file, copy.path("patches/rustdds/0001-renamed.patch")).expect("a file moves");
    copy.set_up();
    assert_eq!(copy.corrections()[0], "0001-renamed");

    // Nothing is left of the copies before.
    let copies = fs::read_dir(copy.path(".cargo/corrected")).expect("the copies");
    let copies = copies.filter(|entry| entry.as_ref().expect("an entry").path().is_dir());
    assert_eq!(copies.count(), 1);
}

#[test]
fn cargo_works_after_the_corrections_were_deleted() {
    let copy = Copy::new();
    copy.set_up();
    fs::remove_dir_all(copy.path(".cargo/corrected")).expect("the copies are gone");
    let metadata = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .current_dir(copy.directory.path())
        .output()
        .expect("cargo runs");
    assert!(metadata.status.success(), "{}", String::from_utf8_lossy(&metadata.stderr));
    copy.set_up();
    assert_eq!(copy.corrections(), patches(repository()));
}

/// Cargo takes the copy of a directory above, which may have other corrections.
#[test]
fn setup_refuses_a_clone_that_another_ones_corrections_would_be_used_in() {
    let outer = Copy::new();
    outer.set_up();
    let inner = outer.path("inner");
    copy_sources(repository(), &inner);
    let mut setup = Command::new(inner.join("launch_scripts/setup.sh"));
    let output = setup.env_remove("EVAC_UNCORRECTED").output().expect("setup.sh runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(error.contains("put the clone elsewhere"), "{error}");
}

#[test]
fn setup_says_which_patch_does_not_apply() {
    let copy = Copy::new();
    copy.set_up();
    let file = copy.path("patches/rustdds/0002-data-frag-inline-qos.patch");
    let text = fs::read_to_string(&file).expect("a patch").replace("-    if self", "-    if other");
    fs::write(&file, text).expect("a file");
    let output = copy.setup().output().expect("setup.sh runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(error.contains("0002-data-frag-inline-qos.patch does not apply"), "{error}");
    assert!(
        !copy.path(".cargo/corrected/config.toml").exists(),
        "cargo builds as if it had not run"
    );
}
