//! Training runs whose nodes are stopped, frozen or traced twenty times, for one to three seconds
//! each. The result must match that of an undisturbed training run.
//!
//! These tests need a corrected build, root, a cgroup freezer and strace.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread::sleep,
    time::Duration,
};

use evac_tests::{Nodes, assert_survives};
use ros_runtime::corrections::is_corrected;

const COUNT: usize = 20;
/// Longer than the longest wait of RustDDS's event loops.
const PAUSE: Duration = Duration::from_secs(3);
/// Duration of a step in seconds. A training run of about 3,000 such steps outlasts the
/// interruptions.
const STEP_TIME: f64 = 0.01;

fn nodes() -> Nodes {
    assert!(is_corrected(), "RustDDS is not patched: run launch_scripts/setup.sh and rebuild");
    Nodes::new()
}

#[test]
fn training_survives_stopped_and_continued_nodes() {
    assert_survives(nodes(), COUNT, STEP_TIME, |nodes, name| {
        nodes.signal(name, "STOP");
        sleep(PAUSE);
        nodes.signal(name, "CONT");
    });
}

/// `docker pause` freezes a container in the same way.
#[test]
fn training_survives_nodes_frozen_by_a_cgroup() {
    let freezers = Freezer::all();
    assert!(!freezers.is_empty(), "no cgroup freezer found in /proc/mounts");
    for freezer in &freezers {
        assert_survives(nodes(), COUNT, STEP_TIME, |nodes, name| {
            freezer.add(nodes.process_id(name));
            freezer.set(true);
            sleep(PAUSE);
            freezer.set(false);
            freezer.remove(nodes.process_id(name));
        });
    }
}

#[test]
fn training_survives_traced_nodes() {
    assert_survives(nodes(), COUNT, STEP_TIME, |nodes, name| {
        let process = nodes.process_id(name).to_string();
        let trace = Command::new("timeout")
            .args(["1", "strace", "--follow-forks", "--trace=none", "--attach", &process])
            .stderr(Stdio::null())
            .status();
        // Status 124 is the timeout: strace was attached the whole time.
        assert_eq!(trace.expect("timeout runs").code(), Some(124), "strace exited early");
    });
}

/// A cgroup (version 1 or 2) that can be frozen. It is removed when this value is dropped.
struct Freezer {
    /// The root of the hierarchy, to which processes return.
    root: PathBuf,
    group: PathBuf,
    /// The control file in the group.
    file: &'static str,
    /// The values that freeze and thaw the group.
    words: [&'static str; 2],
}

impl Freezer {
    /// Creates a group in each cgroup hierarchy that has a freezer.
    fn all() -> Vec<Freezer> {
        let mounts = fs::read_to_string("/proc/mounts").expect("/proc is mounted");
        let mut freezers = Vec::new();
        for mount in mounts.lines() {
            let fields: Vec<&str> = mount.split(' ').collect();
            let [_, mount_point, kind, options, ..] = fields[..] else { continue };
            let (file, words) = match kind {
                "cgroup2" => ("cgroup.freeze", ["1", "0"]),
                "cgroup" if options.split(',').any(|option| option == "freezer") => {
                    ("freezer.state", ["FROZEN", "THAWED"])
                }
                _ => continue,
            };
            let root = Path::new(mount_point);
            let group = root.join(format!("evac-tests-{}", std::process::id()));
            fs::create_dir(&group).expect("permission to create a cgroup");
            freezers.push(Freezer { root: root.to_owned(), group, file, words });
        }
        freezers
    }

    fn add(&self, process: u32) {
        fs::write(self.group.join("cgroup.procs"), process.to_string()).expect("a process");
    }

    fn remove(&self, process: u32) {
        fs::write(self.root.join("cgroup.procs"), process.to_string()).expect("a process");
    }

    fn set(&self, is_frozen: bool) {
        let word = self.words[usize::from(!is_frozen)];
        fs::write(self.group.join(self.file), word).expect("a writable control file");
    }
}

impl Drop for Freezer {
    fn drop(&mut self) {
        let _ = fs::write(self.group.join(self.file), self.words[1]);
        // Fails if the test has failed, because its process is then still in the group.
        let _ = fs::remove_dir(&self.group);
    }
}
