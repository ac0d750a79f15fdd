//! The result of a training run, for bit-exact comparisons of training runs.

use std::{fs, path::Path};

use learning::{
    checkpoint::model_bytes,
    run::RunDirectory,
    settings::{Preset, Settings},
    training::{Plan, Training},
};
use sim_node::world::WorldSettings;

use crate::{NullListener, Room};

/// The contents of `episodes.csv` and `model.safetensors` of a training run.
#[derive(PartialEq, Eq)]
pub struct Outcome {
    episodes: Vec<u8>,
    model: Vec<u8>,
}

impl Outcome {
    /// Trains in this process, in environments that truncate an episode after `max_steps` steps.
    /// Writes `episodes.csv` to `directory`.
    ///
    /// # Panics
    ///
    /// Panics if training fails or `directory` cannot be written to.
    pub fn in_process(plan: Plan, preset: Preset, max_steps: u32, directory: &Path) -> Outcome {
        let world = WorldSettings { max_steps, ..WorldSettings::default() };
        Outcome::with_settings(plan, preset.settings(), world, directory)
    }

    /// Trains like [`Outcome::in_process`], with arbitrary hyperparameters and world settings.
    ///
    /// # Panics
    ///
    /// Panics if training fails or `directory` cannot be written to.
    pub fn with_settings(
        plan: Plan,
        settings: Settings,
        world: WorldSettings,
        directory: &Path,
    ) -> Outcome {
        let room = |_| Room::new(world.clone());
        let mut rooms: Vec<Room> = (0..plan.rooms).map(room).collect();
        let mut training = Training::new(plan, settings).expect("the settings are valid");
        training.run(&mut rooms, &mut NullListener).expect("training succeeds");
        let directory = RunDirectory::open(directory).expect("the directory can be created");
        directory.write_episodes(&training.progress.records).expect("the file can be written");
        let episodes = fs::read(directory.file("episodes.csv")).expect("it was just written");
        Outcome { episodes, model: model_bytes(training.learner().network()).expect("weights") }
    }

    /// Reads the result of `agent_node train` from its output directory.
    ///
    /// # Panics
    ///
    /// Panics if one of the files cannot be read.
    pub fn read_from(out: &Path) -> Outcome {
        let read = |name: &str| fs::read(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        Outcome { episodes: read("episodes.csv"), model: read("model.safetensors") }
    }

    /// Returns the number of episodes.
    pub fn episodes(&self) -> usize {
        self.lengths().len()
    }

    /// Returns the number of steps in all episodes together.
    pub fn steps(&self) -> u64 {
        self.lengths().iter().sum()
    }

    /// Returns the number of steps of each episode.
    fn lengths(&self) -> Vec<u64> {
        let text = String::from_utf8_lossy(&self.episodes);
        let steps = |line: &str| line.split(',').nth(1).and_then(|steps| steps.parse().ok());
        text.lines().skip(1).map(|line| steps(line).expect("the row has steps")).collect()
    }

    /// Asserts that both results are bit-identical. Does not print the weights if they differ.
    ///
    /// # Panics
    ///
    /// Panics if they differ.
    #[track_caller]
    pub fn assert_identical(&self, expected: &Outcome) {
        let text = |outcome: &Outcome| String::from_utf8_lossy(&outcome.episodes).into_owned();
        assert_eq!(text(self), text(expected), "episodes.csv differs");
        assert!(self.model == expected.model, "model.safetensors differs");
    }
}
