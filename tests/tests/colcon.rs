//! Checks that colcon finds, builds and installs the ROS packages of this repository.
//!
//! Needs colcon with its extensions for ROS and CMake, and ament_cmake (Debian 12: `ament-cmake
//! colcon python3-colcon-ros python3-colcon-package-information python3-colcon-package-selection`).
//! If ROS 2 is sourced, the tests use it and also build `evac_msgs`, whose message generators are
//! not in Debian.

use std::{collections::BTreeMap, path::Path, process::Command};

use evac_tests::{binary, repository};
use ros_runtime::corrections::RUSTDDS;

/// Runs colcon in a directory, which receives its output files, and returns its standard output.
fn colcon(directory: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new("colcon");
    command.args(arguments).args(["--base-paths", repository().to_str().expect("Unicode")]);
    // Uses the target directory of the tests, so that cargo has nothing to rebuild.
    let target = binary("sim_node").ancestors().nth(2).expect("target/release").to_owned();
    command.env("CARGO_TARGET_DIR", target);
    if !has_ros() {
        // Selects the system's Python, for which ament_cmake is installed.
        let cargo = Path::new(env!("CARGO")).parent().expect("cargo is in a directory");
        command.env("PATH", format!("{}:/usr/bin:/bin", cargo.display()));
    }
    let output = command.current_dir(directory).output().expect("colcon runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    text
}

fn has_ros() -> bool {
    std::env::var_os("ROS_DISTRO").is_some()
}

#[test]
fn colcon_finds_exactly_our_packages() {
    let directory = tempfile::tempdir().expect("a directory");
    let text = colcon(directory.path(), &["list"]);
    let packages: BTreeMap<&str, &str> = text
        .lines()
        .map(|line| line.split('\t').collect::<Vec<_>>())
        .map(|fields| (fields[0], fields[2]))
        .collect();
    let names = ["agent_node", "evac_bringup", "evac_msgs", "sim_node"];
    assert_eq!(packages, names.map(|name| (name, "(ros.ament_cmake)")).into());
}

#[test]
fn colcon_installs_corrected_nodes_without_rebuilding_them() {
    // These are the nodes that the tests use, since colcon builds in the same target directory.
    let before = ["sim_node", "agent_node"].map(modified);
    let directory = tempfile::tempdir().expect("a directory");
    let ignored = ["--packages-ignore", "evac_msgs"];
    let arguments = [&["build"][..], if has_ros() { &[] } else { &ignored }].concat();
    colcon(directory.path(), &arguments);
    assert_eq!(["sim_node", "agent_node"].map(modified), before, "cargo rebuilt the nodes");

    let install = directory.path().join("install");
    for name in ["sim_node", "agent_node"] {
        let node = install.join(name).join("lib").join(name).join(name);
        let version = Command::new(node).arg("--version").output().expect("the node is installed");
        let version = String::from_utf8_lossy(&version.stdout).into_owned();
        assert!(version.trim().ends_with(RUSTDDS) && RUSTDDS.ends_with("(corrected)"), "{version}");
    }
    let evac = install.join("evac_bringup/lib/evac_bringup/evac");
    let prefixes = ["sim_node", "agent_node"].map(|name| install.join(name));
    let prefixes = std::env::join_paths(prefixes).expect("paths without colons");
    let mut help = Command::new(evac);
    help.args(["train", "--help"]).env("AMENT_PREFIX_PATH", prefixes);
    let help = help.output().expect("evac is installed").stdout;
    assert!(String::from_utf8_lossy(&help).contains("--episodes"), "evac does not find the nodes");
    let share = install.join("evac_bringup/share/evac_bringup");
    for file in ["launch/train.launch.py", "launch/drive.launch.py", "rviz/evac.rviz"] {
        assert!(share.join(file).exists(), "{file} is not installed");
    }
}

fn modified(name: &str) -> std::time::SystemTime {
    binary(name).metadata().and_then(|metadata| metadata.modified()).expect("the node is built")
}
