//! What a training leaves, to compare one with another.

use std::{fs, path::Path};

use learning::{
    checkpoint::model_bytes,
    run::RunDirectory,
    settings::{Preset, Settings},
    training::{Plan, Training},
};
use sim_node::world::WorldSettings;

use crate::{Room, Silent};

/// The episodes and the weights of a training, as its files have them.
#[derive(PartialEq, Eq)]
pub struct Outcome {
    episodes: Vec<u8>,
    model: Vec<u8>,
}

impl Outcome {
    /// Of a training in this process, in rooms where an episode has at most so many steps.
    /// `directory` is for what it writes.
    pub fn in_process(plan: Plan, preset: Preset, max_steps: u32, directory: &Path) -> Outcome {
        Outcome::with_settings(plan, preset.settings(), max_steps, directory)
    }

    /// As [`Outcome::in_process`], with any hyperparameters.
    pub fn with_settings(
        plan: Plan,
        settings: Settings,
        max_steps: u32,
        directory: &Path,
    ) -> Outcome {
        let room = |_| Room::new(WorldSettings { max_steps, ..Default::default() });
        let mut rooms: Vec<Room> = (0..plan.rooms).map(room).collect();
        let mut training = Training::new(plan, settings).expect("a network");
        training.run(&mut rooms, &mut Silent).expect("a training");
        let directory = RunDirectory::open(directory).expect("a directory");
        directory.write_episodes(&training.progress.records).expect("episodes.csv");
        let episodes = fs::read(directory.file("episodes.csv")).expect("it was just written");
        Outcome { episodes, model: model_bytes(training.learner().network()).expect("weights") }
    }

    /// Of a run of `agent_node train` with this `out`.
    pub fn left_in(out: &Path) -> Outcome {
        let read = |name: &str| fs::read(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        Outcome { episodes: read("episodes.csv"), model: read("model.safetensors") }
    }

    /// How many episodes there were.
    pub fn episodes(&self) -> usize {
        self.lengths().len()
    }

    /// Steps of all episodes.
    pub fn steps(&self) -> u64 {
        self.lengths().iter().sum()
    }

    /// Steps of each episode.
    fn lengths(&self) -> Vec<u64> {
        let text = String::from_utf8_lossy(&self.episodes);
        let steps = |line: &str| line.split(',').nth(1).and_then(|steps| steps.parse().ok());
        text.lines().skip(1).map(|line| steps(line).expect("a row of episodes.csv")).collect()
    }

    /// Fails unless it is the other to the bit, without printing a megabyte.
    #[track_caller]
    pub fn assert_is(&self, expected: &Outcome) {
        let text = |outcome: &Outcome| String::from_utf8_lossy(&outcome.episodes).into_owned();
        assert_eq!(text(self), text(expected), "episodes.csv");
        assert!(self.model == expected.model, "model.safetensors differs");
    }
}
