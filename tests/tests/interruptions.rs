//! Trainings whose nodes are stopped, frozen or traced twenty times, for seconds: the same result.
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
/// Longer than the event loops of RustDDS wait at most.
const PAUSE: Duration = Duration::from_secs(3);
/// Some 3,000 steps last longer than twenty interruptions and the steps between them.
const STEP_TIME: f64 = 0.01;

fn nodes() -> Nodes {
    assert!(is_corrected(), "RustDDS is uncorrected: run launch_scripts/setup.sh and build again");
    Nodes::new()
}

#[test]
fn stopped_and_continued() {
    assert_survives(nodes(), COUNT, STEP_TIME, |nodes, name| {
        nodes.signal(name, "STOP");
        sleep(PAUSE);
        nodes.signal(name, "CONT");
    });
}

#[test]
fn frozen_by_a_cgroup_as_docker_pause_does() {
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
fn traced_for_a_second() {
    assert_survives(nodes(), COUNT, STEP_TIME, |nodes, name| {
        let process = nodes.process_id(name).to_string();
        let trace = Command::new("timeout")
            .args(["1", "strace", "--follow-forks", "--trace=none", "--attach", &process])
            .stderr(Stdio::null())
            .status();
        // timeout's own status: strace was there, and attached until its end.
        assert_eq!(trace.expect("timeout runs").code(), Some(124), "strace ended by itself");
    });
}

/// A cgroup that can be frozen, of version 1 or 2, until this value is dropped.
struct Freezer {
    /// The root of the hierarchy, which processes are put back to.
    root: PathBuf,
    group: PathBuf,
    /// The file that freezes the group, and what is written to it to freeze and to thaw.
    file: &'static str,
    words: [&'static str; 2],
}

impl Freezer {
    /// One in each hierarchy of this machine that has a freezer.
    fn all() -> Vec<Freezer> {
        let mounts = fs::read_to_string("/proc/mounts").expect("there is /proc");
        let mut freezers = Vec::new();
        for mount in mounts.lines() {
            let fields: Vec<&str> = mount.split(' ').collect();
            let [_, place, kind, options, ..] = fields[..] else { continue };
            let (file, words) = match kind {
                "cgroup2" => ("cgroup.freeze", ["1", "0"]),
                "cgroup" if options.split(',').any(|option| option == "freezer") => {
                    ("freezer.state", ["FROZEN", "THAWED"])
                }
                _ => continue,
            };
            let root = Path::new(place);
            let group = root.join(format!("evac-tests-{}", std::process::id()));
            fs::create_dir(&group).expect("root may create a cgroup");
            freezers.push(Freezer { root: root.to_owned(), group, file, words });
        }
        freezers
    }

    fn add(&self, process: u32) {
        fs::write(self.group.join("cgroup.procs"), process.to_string()).expect("a process moves");
    }

    fn remove(&self, process: u32) {
        fs::write(self.root.join("cgroup.procs"), process.to_string()).expect("a process moves");
    }

    fn set(&self, is_frozen: bool) {
        let word = self.words[usize::from(!is_frozen)];
        fs::write(self.group.join(self.file), word).expect("the group obeys");
    }
}

impl Drop for Freezer {
    fn drop(&mut self) {
        let _ = fs::write(self.group.join(self.file), self.words[1]);
        // Fails while a process of a failed test is in it.
        let _ = fs::remove_dir(&self.group);
    }
}
