//! The ROS packages of this repository, as colcon finds, builds and installs them.
//!
//! Needs colcon with its extensions for ROS and CMake, and ament_cmake (Debian 12: `ament-cmake colcon
//! python3-colcon-ros python3-colcon-package-information python3-colcon-package-selection`). Where a ROS 2
//! is sourced it is used, and `evac_msgs` is built, too: the generators of messages are not in Debian.

use std::{collections::BTreeMap, path::Path, process::Command};

use evac_tests::{binary, repository};
use ros_runtime::corrections::RUSTDDS;

/// colcon with some words after it, called in a directory, which it leaves its files in.
fn colcon(directory: &Path, words: &[&str]) -> String {
    let mut command = Command::new("colcon");
    command.args(words).args(["--base-paths", repository().to_str().expect("Unicode")]);
    // Beside the program that is tested, wherever cargo has built it.
    let target = binary("sim_node").ancestors().nth(2).expect("target/release").to_owned();
    command.env("CARGO_TARGET_DIR", target);
    if !has_ros() {
        // The Python that ament_cmake is installed for, and not one of another place.
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
fn colcon_finds_our_packages_and_no_others() {
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
fn colcon_installs_corrected_nodes_and_builds_nothing_twice() {
    // The nodes as the tests have them: colcon builds in the same target directory.
    let before = ["sim_node", "agent_node"].map(modified);
    let directory = tempfile::tempdir().expect("a directory");
    let ignored = ["--packages-ignore", "evac_msgs"];
    let words = [&["build"][..], if has_ros() { &[] } else { &ignored }].concat();
    colcon(directory.path(), &words);
    assert_eq!(["sim_node", "agent_node"].map(modified), before, "cargo has built them anew");

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
    assert!(String::from_utf8_lossy(&help).contains("--episodes"), "evac finds the nodes");
    let share = install.join("evac_bringup/share/evac_bringup");
    for file in ["launch/train.launch.py", "launch/drive.launch.py", "rviz/evac.rviz"] {
        assert!(share.join(file).exists(), "{file} is not installed");
    }
}

fn modified(name: &str) -> std::time::SystemTime {
    binary(name).metadata().and_then(|metadata| metadata.modified()).expect("the node is built")
}
