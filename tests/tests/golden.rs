//! Golden results: the digests of short training runs with both presets. They are the same on every
//! machine and must not change between versions.

use evac_tests::{NullListener, Room};
use learning::{
    checkpoint::model_bytes,
    perceptron::{Arch, arches},
    run::RunDirectory,
    settings::Preset,
    training::{Plan, Training},
};
use sha2::{Digest, Sha256};
use sim_node::world::WorldSettings;

/// The digests of `episodes.csv` and `model.safetensors` after 40 episodes with seed 5.
const GOLDEN: [(Preset, &str, [&str; 2]); 2] = [
    (Preset::Paper, "empty", ["37ceece2a4b44a2c", "034bc494f4ed2ae2"]),
    (Preset::Robust, "concave", ["4bcf0ae43e1c456c", "ca93f4c84930b892"]),
];

/// Trains in this process and returns the digests of `episodes.csv` and `model.safetensors`.
fn digests(
    preset: Preset,
    scenario: &str,
    episodes: u32,
    max_steps: u32,
    arch: Arch,
) -> [String; 2] {
    let plan = Plan { scenario: scenario.to_owned(), episodes, seed: 5, rooms: 1 };
    let mut training = Training::new(plan, preset.settings()).expect("a network");
    training.set_arch(arch);
    let settings = WorldSettings { max_steps, ..WorldSettings::default() };
    training.run(&mut [Room::new(settings)], &mut NullListener).expect("a training run");
    let directory = tempfile::tempdir().expect("a directory");
    let directory = RunDirectory::open(directory.path()).expect("a directory");
    directory.write_episodes(&training.progress.records).expect("a file");
    let records = std::fs::read(directory.file("episodes.csv")).expect("it was just written");
    let model = model_bytes(training.learner().network()).expect("weights");
    [records, model]
        .map(|bytes| Sha256::digest(bytes)[..8].iter().map(|byte| format!("{byte:02x}")).collect())
}

/// The digests are those of `train.sh --randomization none --preset PRESET --scenario SCENARIO --seed 5 --episodes 40`.
#[test]
fn training_runs_match_their_golden_digests() {
    for (preset, scenario, expected) in GOLDEN {
        let found = digests(preset, scenario, 40, 10_000, Arch::new());
        assert_eq!(found, expected, "{preset}");
    }
}

/// Repeats [`training_runs_match_their_golden_digests`] with scalar code and with the vector
/// instructions that this processor supports, such as AVX2 and AVX-512.
#[test]
#[ignore = "takes a quarter of an hour: scalar code is slow"]
fn all_instruction_sets_match_the_golden_digests() {
    for arch in arches() {
        for (preset, scenario, expected) in GOLDEN {
            let found = digests(preset, scenario, 40, 10_000, arch);
            assert_eq!(found, expected, "{preset}, {arch:?}");
        }
    }
}

/// Uses scalar code and the vector instructions that this processor supports. The training runs are
/// short because scalar code is slow.
#[test]
fn all_instruction_sets_give_the_same_result() {
    for (preset, expected) in [
        (Preset::Paper, ["5fd039e93439e8bd", "8ba88d2e9058de97"]),
        (Preset::Robust, ["ae90fa4a4a551d8b", "18823a3315c6aa9e"]),
    ] {
        for arch in arches() {
            let found = digests(preset, "three_moving", 6, 60, arch);
            assert_eq!(found, expected, "{preset}, {arch:?}");
        }
    }
}
