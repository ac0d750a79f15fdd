//! Saving a training while it goes on, and taking it up again.

use std::{
    fs,
    sync::mpsc::{SyncSender, sync_channel},
    thread::{Builder, JoinHandle},
};

use anyhow::Context;
use log::warn;

use crate::{
    checkpoint::{LoadError, model_bytes},
    run::RunDirectory,
    settings::Settings,
    training::{Plan, Training},
};

/// Writes `episodes.csv`, the model and the checkpoint of a training.
pub fn write(training: &Training, directory: &RunDirectory) -> anyhow::Result<()> {
    directory.write_episodes(&training.progress.records)?;
    directory.write(RunDirectory::MODEL, &model_bytes(training.learner().network())?)?;
    // Last, so that a checkpoint never knows more than the files beside it.
    directory.write_and_keep(
        RunDirectory::CHECKPOINT,
        RunDirectory::PREVIOUS_CHECKPOINT,
        |path| Ok(training.write_checkpoint(path)?),
    )?;
    Ok(())
}

/// Takes up the training of the last checkpoint, or, with a warning, that of the one before if the
/// last one is damaged or was never finished.
pub fn load(
    directory: &RunDirectory,
    plan: &Plan,
    settings: &Settings,
) -> Result<Training, LoadError> {
    let load = |name| Training::load(&directory.file(name), plan.clone(), settings.clone());
    let error = match load(RunDirectory::CHECKPOINT) {
        Err(error @ (LoadError::Read { .. } | LoadError::Damaged { .. })) => error,
        result => return result,
    };
    match load(RunDirectory::PREVIOUS_CHECKPOINT) {
        Ok(training) => {
            warn!("{error}; going on with the checkpoint before that one");
            // Or the next one would take the place of the only good one.
            let last = directory.file(RunDirectory::CHECKPOINT);
            if last.exists() {
                let aside = directory.file(RunDirectory::DAMAGED_CHECKPOINT);
                fs::rename(&last, aside).map_err(|source| LoadError::Read {
                    path: last.display().to_string(),
                    source,
                })?;
            }
            Ok(training)
        }
        // Where there is none, the last one is what is wrong.
        Err(LoadError::Read { .. }) => Err(error),
        Err(previous) => {
            warn!("{error}");
            Err(previous)
        }
    }
}

/// A thread that writes copies of a training, so that the learner does not wait for the disk.
pub struct Saver {
    /// None once the thread shall end.
    trainings: Option<SyncSender<Training>>,
    thread: Option<JoinHandle<()>>,
}

impl Saver {
    /// Starts the thread.
    pub fn start(directory: &RunDirectory) -> anyhow::Result<Saver> {
        // None waits in line: where the disk is slower than the training, the training waits.
        let (trainings, next) = sync_channel::<Training>(0);
        let directory = directory.clone();
        let write = move || {
            for training in next {
                // A disk may have room again, and the training is worth more than a copy of it.
                if let Err(error) = write(&training, &directory) {
                    warn!("{error:#}: the training goes on, and is saved again later");
                }
            }
        };
        let thread = Builder::new().name("saver".into()).spawn(write);
        let thread = Some(thread.context("no thread to save the training")?);
        Ok(Saver { trainings: Some(trainings), thread })
    }

    /// Saves a training; what cannot be written is told of by a warning.
    ///
    /// # Errors
    ///
    /// If there is no thread any more.
    pub fn save(&self, training: &Training) -> anyhow::Result<()> {
        let is_sent =
            self.trainings.as_ref().is_some_and(|line| line.send(training.clone()).is_ok());
        anyhow::ensure!(is_sent, "the thread that saves the training has ended");
        Ok(())
    }
}

impl Drop for Saver {
    /// Waits until everything is written.
    fn drop(&mut self) {
        self.trainings = None;
        if let Some(thread) = self.thread.take() {
            // A panic there was told of when it happened.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Preset;

    #[test]
    fn a_checkpoint_that_cannot_be_used_is_followed_by_the_one_before() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::open(home.path()).unwrap();
        let plan = Plan { scenario: "empty".into(), episodes: 10, seed: 3, rooms: 1 };
        let settings = Preset::Paper.settings();
        let load = || load(&run, &plan, &settings);
        assert!(matches!(load(), Err(LoadError::Read { .. })));

        let mut training = Training::new(plan.clone(), settings.clone()).unwrap();
        write(&training, &run).unwrap();
        training.progress.total_steps = 7;
        write(&training, &run).unwrap();
        assert_eq!(load().unwrap().progress.total_steps, 7);

        let last = run.file(RunDirectory::CHECKPOINT);
        let mut bytes = fs::read(&last).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&last, &bytes).unwrap();
        assert_eq!(load().unwrap().progress.total_steps, 0);
        // Now as after a power cut between the two names.
        assert!(!last.exists());
        assert_eq!(load().unwrap().progress.total_steps, 0);
        // Whoever goes on has a good one behind him.
        write(&training, &run).unwrap();
        fs::remove_file(&last).unwrap();
        assert_eq!(load().unwrap().progress.total_steps, 0);

        // Where both are wrong, the last one is told of, and the one before it is the error.
        fs::write(&last, &bytes).unwrap();
        fs::write(run.file(RunDirectory::PREVIOUS_CHECKPOINT), b"").unwrap();
        let message = load().unwrap_err().to_string();
        assert!(message.contains("checkpoint.previous.safetensors is damaged"), "{message}");

        // Of another training is no damage.
        write(&training, &run).unwrap();
        let other = Plan { seed: 4, ..plan.clone() };
        assert!(matches!(super::load(&run, &other, &settings), Err(LoadError::DoesNotFit { .. })));
    }
}
