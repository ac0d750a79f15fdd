//! Checks the build: the features of RustDDS in every package selection, and the patches that
//! setup.sh applies to it.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use evac_tests::repository;

/// Runs cargo, which must succeed, and returns its standard output.
fn cargo(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(repository())
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Returns the features of the given packages when cargo builds `selection`. A package that is also
/// built for procedural macros has two sets.
fn features(packages: &BTreeSet<String>, selection: &str) -> BTreeMap<String, BTreeSet<String>> {
    let tree = ["tree", "--locked", "--prefix", "none", "--format", "{p}|{f}"];
    let arguments: Vec<&str> = tree.into_iter().chain(selection.split(' ')).collect();
    let mut features: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in cargo(&arguments).lines() {
        let Some((package, enabled)) = line.split_once('|') else { continue };
        let name = package.split(' ').take(2).collect::<Vec<_>>().join(" ");
        if packages.contains(&name) {
            let enabled = enabled.trim_end_matches(" (*)").to_owned();
            features.entry(name).or_default().insert(enabled);
        }
    }
    features
}

/// With different features, `cargo test` for one package would rebuild RustDDS, and the next script
/// would rebuild it again.
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
            // A subset is enough: Cargo resolves the dependencies of procedural macros separately, so
            // a package can have two sets of features, and a selection without those macros has only
            // one of them.
            let expected = nodes.get(&package).expect("the nodes also depend on it");
            assert!(
                found.is_subset(expected),
                "{selection}: {package} has the features {found:?} (expected: {expected:?}): add \
                 them to crates/workspace_features/Cargo.toml"
            );
        }
    }
}

/// Compares `rust-version` of this workspace with that of every dependency. For our own use of std,
/// clippy's `incompatible_msrv` does the same.
#[test]
fn no_dependency_needs_a_newer_rust_than_the_workspace() {
    let version = |version: &str| -> (u32, u32) {
        let mut parts = version.split('.').map(|part| part.parse().expect("a number"));
        (parts.next().expect("major"), parts.next().expect("minor"))
    };
    let metadata = cargo(&["metadata", "--locked", "--format-version", "1"]);
    let metadata: serde_json::Value = serde_json::from_str(&metadata).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let required = |package: &serde_json::Value| package["rust_version"].as_str().map(version);
    let name = |package: &serde_json::Value| package["name"].as_str().map(str::to_owned);
    let own = packages.iter().find(|package| package["name"] == "evac_tests").and_then(required);
    let newer = packages.iter().filter(|package| required(package) > own).filter_map(name);
    assert_eq!(newer.collect::<Vec<_>>(), Vec::<String>::new(), "rust-version is {own:?}");
    let count = packages.iter().filter_map(required).count();
    assert!(count > 100, "only {count} packages have a rust_version");
}

/// A copy of the sources without build artifacts, in which setup.sh has not run yet.
struct FreshClone {
    directory: tempfile::TempDir,
}

impl FreshClone {
    fn new() -> FreshClone {
        let directory = tempfile::tempdir().expect("a directory");
        copy_sources(repository(), directory.path());
        FreshClone { directory }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn setup(&self) -> Command {
        let mut setup = Command::new(self.path("launch_scripts/setup.sh"));
        // This variable is set when the tests run with an uncorrected build.
        setup.env_remove("EVAC_UNCORRECTED");
        setup
    }

    fn set_up(&self) {
        let output = self.setup().output().expect("setup.sh runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    /// Returns the directory of the corrected RustDDS that cargo's configuration names.
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

/// Copies manifests, sources and scripts. Skips build artifacts and hidden files, except for
/// `.cargo/config.toml`.
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

/// Returns the names of the patches in the order in which they are applied.
fn patches(directory: &Path) -> Vec<String> {
    let files = fs::read_dir(directory.join("patches/rustdds")).expect("the patches");
    let names = files.map(|file| file.expect("a file").file_name().into_string().expect("Unicode"));
    let mut names: Vec<String> =
        names.filter_map(|name| name.strip_suffix(".patch").map(str::to_owned)).collect();
    names.sort();
    names
}

#[test]
fn setup_corrects_rustdds_once_and_again_when_a_patch_changes() {
    let clone = FreshClone::new();
    let all = patches(repository());
    // Concurrent runs are safe.
    let both: Vec<_> = (0..2).map(|_| clone.setup().spawn().expect("setup.sh runs")).collect();
    for mut setup in both {
        assert!(setup.wait().expect("a child process").success());
    }
    assert_eq!(clone.corrections(), all);
    let metadata = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .current_dir(clone.path("sim_node"))
        .output()
        .expect("cargo runs");
    let metadata = String::from_utf8(metadata.stdout).expect("JSON");
    let corrected = clone.corrected();
    assert!(metadata.contains(corrected.to_str().expect("Unicode")), "cargo does not use the copy");

    // If the copy is up to date, nothing is written.
    let written = |path: PathBuf| fs::metadata(path).expect("a file").modified().expect("a time");
    let before = written(clone.path(".cargo/corrected/config.toml"));
    clone.set_up();
    assert_eq!(written(clone.path(".cargo/corrected/config.toml")), before);

    // The patches are independent: without any one of them, the others still apply.
    let removed = tempfile::tempdir().expect("a directory");
    for name in &all {
        let file = clone.path("patches/rustdds").join(format!("{name}.patch"));
        fs::rename(&file, removed.path().join("patch")).expect("the patch is moved");
        clone.set_up();
        let others: Vec<String> = all.iter().filter(|other| *other != name).cloned().collect();
        assert_eq!(clone.corrections(), others);
        fs::rename(removed.path().join("patch"), &file).expect("the patch is moved back");
    }
    // A correction is identified by its file name.
    let file = clone.path("patches/rustdds").join(format!("{}.patch", all[0]));
    fs::rename(&file, clone.path("patches/rustdds/0001-renamed.patch")).expect("a renamed patch");
    clone.set_up();
    assert_eq!(clone.corrections()[0], "0001-renamed");

    // Outdated copies of RustDDS are removed.
    let copies = fs::read_dir(clone.path(".cargo/corrected")).expect("the copies");
    let copies = copies.filter(|entry| entry.as_ref().expect("an entry").path().is_dir());
    assert_eq!(copies.count(), 1);
}

#[test]
fn cargo_works_after_the_corrections_were_deleted() {
    let clone = FreshClone::new();
    clone.set_up();
    fs::remove_dir_all(clone.path(".cargo/corrected")).expect("the copies are removed");
    let metadata = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .current_dir(clone.directory.path())
        .output()
        .expect("cargo runs");
    assert!(metadata.status.success(), "{}", String::from_utf8_lossy(&metadata.stderr));
    clone.set_up();
    assert_eq!(clone.corrections(), patches(repository()));
}

/// Cargo would use the corrected copy in the enclosing clone, which may have different patches.
#[test]
fn setup_refuses_a_clone_inside_another_corrected_clone() {
    let outer = FreshClone::new();
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
fn setup_names_the_patch_that_does_not_apply() {
    let clone = FreshClone::new();
    clone.set_up();
    let file = clone.path("patches/rustdds/0002-data-frag-inline-qos.patch");
    let text = fs::read_to_string(&file).expect("a patch").replace("-    if self", "-    if other");
    fs::write(&file, text).expect("a file");
    let output = clone.setup().output().expect("setup.sh runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(error.contains("0002-data-frag-inline-qos.patch does not apply"), "{error}");
    assert!(
        !clone.path(".cargo/corrected/config.toml").exists(),
        "the outdated corrections are still in use"
    );
}
