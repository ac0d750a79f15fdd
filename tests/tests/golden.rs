//! One seed, one result, on every machine and by every version: short trainings of both presets, by
//! their digests.

use evac_tests::{Room, Silent};
use learning::{
    checkpoint::model_bytes,
    perceptron::{Arch, arches},
    run::RunDirectory,
    settings::Preset,
    training::{Plan, Training},
};
use sha2::{Digest, Sha256};
use sim_node::world::WorldSettings;

/// The digests of `episodes.csv` and `model.safetensors`.
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
    training.run(&mut [Room::new(settings)], &mut Silent).expect("a training");
    let directory = tempfile::tempdir().expect("a directory");
    let directory = RunDirectory::open(directory.path()).expect("a directory");
    directory.write_episodes(&training.progress.records).expect("a file");
    let records = std::fs::read(directory.file("episodes.csv")).expect("it was just written");
    let model = model_bytes(training.learner().network()).expect("weights");
    [records, model]
        .map(|bytes| Sha256::digest(bytes)[..8].iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Those of `train.sh --preset PRESET --scenario SCENARIO --seed 5 --episodes 40`.
#[test]
fn a_training_is_the_same_for_ever() {
    for (preset, scenario, expected) in [
        (Preset::Paper, "empty", ["37ceece2a4b44a2c", "034bc494f4ed2ae2"]),
        (Preset::Robust, "concave", ["953375b684b3dbe0", "1480a558c530e1be"]),
    ] {
        let found = digests(preset, scenario, 40, 10_000, Arch::new());
        assert_eq!(found, expected, "{preset}");
    }
}

/// With AVX-512, AVX2 and no vectors, as far as this processor has them. Without, it takes long.
#[test]
fn a_training_is_the_same_by_all_vectors() {
    for (preset, expected) in [
        (Preset::Paper, ["5fd039e93439e8bd", "8ba88d2e9058de97"]),
        (Preset::Robust, ["8517c8de7573a23f", "50cd187a3dfbee45"]),
    ] {
        for arch in arches() {
            let found = digests(preset, "three_moving", 6, 60, arch);
            assert_eq!(found, expected, "{preset}, {arch:?}");
        }
    }
}
