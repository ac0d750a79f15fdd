//! Code shared by the fuzz targets and the seed generator.

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

/// Files in a temporary directory, which is removed when this value is dropped.
pub struct Files(TempDir);

impl Files {
    /// Writes files with these names and contents, in memory if `/dev/shm` exists.
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

    /// Returns the path of a file.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Returns the path of the directory.
    pub fn directory(&self) -> &str {
        self.0.path().to_str().expect("a UTF-8 path")
    }
}

/// Returns the plan of a short training run.
pub fn plan() -> Plan {
    Plan { scenario: "empty".to_owned(), episodes: 3, seed: 1, rooms: 1 }
}

/// Returns settings with a minimal network and a replay memory that fills within an episode.
pub fn settings() -> Settings {
    Preset::Robust.settings().with(|s| {
        s.network.hidden_layers = vec![2];
        s.network.observation_frames = 2;
        s.replay.capacity = 8;
        s.replay.batch_size = 2;
    })
}

/// An environment with three different images and episodes of ten steps.
pub struct Room {
    steps: u8,
    remaining: u32,
}

impl Room {
    /// Creates an environment that fails after `responses` resets and steps.
    pub fn new(responses: u32) -> Room {
        Room { steps: 0, remaining: responses }
    }

    fn image(&self) -> Image {
        Image::try_from([self.steps % 3; Image::BYTES].as_slice()).expect("an image")
    }

    fn respond(&mut self) -> Result<(), Unavailable> {
        self.remaining = self.remaining.checked_sub(1).ok_or(Unavailable)?;
        Ok(())
    }
}

/// The error for an environment that has failed.
#[derive(Debug)]
pub struct Unavailable;

impl std::error::Error for Unavailable {}

impl std::fmt::Display for Unavailable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the environment is unavailable")
    }
}

impl Environment for Room {
    type Error = Unavailable;
    type PendingReset = ();
    type PendingStep = ();

    fn begin_reset(&mut self, _: NonZeroU64, _: &str) -> Result<(), Unavailable> {
        self.steps = 0;
        self.respond()
    }

    fn finish_reset(&mut self, (): ()) -> Result<Image, Unavailable> {
        Ok(self.image())
    }

    fn begin_step(&mut self, _: Action) -> Result<(), Unavailable> {
        self.respond()
    }

    fn finish_step(&mut self, (): ()) -> Result<Step, Unavailable> {
        self.steps += 1;
        let terminated = self.steps == 10;
        let image = self.image();
        Ok(Step { image, reward: STEP_REWARD, terminated, truncated: false, blocked: false })
    }
}

/// Ignores all events of a training run.
pub struct NullListener;

impl Listener for NullListener {
    fn episode(&mut self, _: &Training, _: &EpisodeRecord) -> anyhow::Result<()> {
        Ok(())
    }
}
