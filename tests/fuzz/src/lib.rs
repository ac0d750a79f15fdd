//! What the targets and their seeds share.

use std::{
    fs,
    num::NonZeroU64,
    path::{Path, PathBuf},
};

use learning::{
    record::EpisodeRecord,
    settings::{Preset, Settings},
    training::{Listener, Plan, Training},
};
use task::{Action, Environment, Image, STEP_REWARD, Step};
use tempfile::TempDir;

/// Files in a directory of their own, which goes with this value.
pub struct Files(TempDir);

impl Files {
    /// Writes files of these names, in memory where the system has a place for that.
    pub fn new(files: &[(&str, &[u8])]) -> Files {
        let memory = Path::new("/dev/shm");
        let directory = match memory.is_dir() {
            true => tempfile::tempdir_in(memory),
            false => tempfile::tempdir(),
        };
        let directory = Files(directory.expect("a directory"));
        for (name, bytes) in files {
            fs::write(directory.path(name), bytes).expect("a file");
        }
        directory
    }

    /// The path of a file.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The path of the directory.
    pub fn directory(&self) -> &str {
        self.0.path().to_str().expect("a path in Unicode")
    }
}

/// A plan of a short training.
pub fn plan() -> Plan {
    Plan { scenario: "empty".to_owned(), episodes: 3, seed: 1, rooms: 1 }
}

/// The smallest network that learns, and a memory that is soon full.
pub fn settings() -> Settings {
    Preset::Robust.settings().with(|s| { s.network.hidden_layers = vec![2]; s.network.observation_frames = 2; s.replay.capacity = 8; s.replay.batch_size = 2; })
}

/// A room of a few images, whose episodes are ten steps long.
pub struct Room {
    steps: u8,
    left: u32,
}

impl Room {
    /// A room that answers so many times.
    pub fn new(answers: u32) -> Room {
        Room { steps: 0, left: answers }
    }

    fn image(&self) -> Image {
        Image::try_from([self.steps % 3; Image::BYTES].as_slice()).expect("an image")
    }

    fn answer(&mut self) -> Result<(), Silence> {
        self.left = self.left.checked_sub(1).ok_or(Silence)?;
        Ok(())
    }
}

/// A room that answers no more.
#[derive(Debug)]
pub struct Silence;

impl std::error::Error for Silence {}

impl std::fmt::Display for Silence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the room answers no more")
    }
}

impl Environment for Room {
    type Error = Silence;
    type PendingReset = ();
    type PendingStep = ();

    fn begin_reset(&mut self, _: NonZeroU64, _: &str) -> Result<(), Silence> {
        self.steps = 0;
        self.answer()
    }

    fn finish_reset(&mut self, (): ()) -> Result<Image, Silence> {
        Ok(self.image())
    }

    fn begin_step(&mut self, _: Action) -> Result<(), Silence> {
        self.answer()
    }

    fn finish_step(&mut self, (): ()) -> Result<Step, Silence> {
        self.steps += 1;
        let terminated = self.steps == 10;
        let image = self.image();
        Ok(Step { image, reward: STEP_REWARD, terminated, truncated: false, blocked: false })
    }
}

/// Listens, and does nothing.
pub struct Silent;

impl Listener for Silent {
    fn episode(&mut self, _: &Training, _: &EpisodeRecord) -> anyhow::Result<()> {
        Ok(())
    }
}
