//! A training run whose disk is temporarily full. The test needs root to mount a small file system.

use std::{
    fs, io,
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use evac_tests::{Nodes, Outcome};
use learning::{
    settings::Preset,
    training::{Plan, Training},
};

const TRAINING: Duration = Duration::from_secs(300);
const MAX_STEPS: u32 = 60;
const EPISODES: u32 = 12;
const SEED: u64 = 5;

/// A tmpfs of 20 MB, which is unmounted when this value is dropped.
struct Disk(PathBuf);

impl Disk {
    fn mount(directory: &Path) -> Disk {
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", "size=20m", "tmpfs"]).arg(directory);
        let output = mount.output().expect("mount runs");
        assert!(output.status.success(), "cannot mount a tmpfs (run as root): {output:?}");
        Disk(directory.to_owned())
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // A lazy unmount succeeds even if a process still has a file open there.
        let _ = Command::new("umount").arg("--lazy").arg(&self.0).status();
    }
}

#[test]
fn training_continues_while_the_disk_is_full() {
    let directory = tempfile::tempdir().expect("a directory");
    let _disk = Disk::mount(directory.path());
    let (out, ballast) = (directory.path().join("run"), directory.path().join("ballast"));
    let mut nodes = Nodes::new();
    // Moves are slow, so that the training is still running when space is freed.
    nodes.start_simulator(&[&format!("max_steps:={MAX_STEPS}"), "motion_time:=0.01"]);
    let out_parameter = format!("out:='{}'", out.display());
    let (episodes, seed) = (format!("episodes:={EPISODES}"), format!("seed:={SEED}"));
    nodes.start_agent(
        "train",
        &[&out_parameter, &episodes, &seed, "evaluation_episodes:=5", "checkpoint_interval:=1"],
    );
    nodes.wait_for_steps(30);
    let mut file = fs::File::create(&ballast).expect("a file");
    let error = io::copy(&mut io::repeat(0), &mut file).expect_err("a disk of 20 MB");
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    nodes.wait_for_log("agent_node", "No space left on device");
    nodes.wait_for_log("agent_node", "training continues, and the next save will try again");
    drop(file);
    fs::remove_file(ballast).expect("the file exists");
    nodes.succeed("agent_node", TRAINING);
    let plan =
        Plan { scenario: task::seeds::MIXED.to_owned(), episodes: EPISODES, seed: SEED, rooms: 1 };
    let preset = Preset::default();
    let here = nodes.path("here");
    Outcome::read_from(&out).assert_identical(&Outcome::in_process(
        plan.clone(),
        preset,
        MAX_STEPS,
        &here,
    ));
    let checkpoint = out.join("checkpoint.safetensors");
    let saved = Training::load(&checkpoint, plan, preset.settings());
    assert_eq!(saved.expect("a checkpoint").episode(), EPISODES);
}
