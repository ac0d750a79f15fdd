//! Saving a training while it goes on, and taking it up again.

use std::{
    sync::mpsc::{SyncSender, sync_channel},
    thread::{Builder, JoinHandle},
};

use anyhow::Context;
use log::warn;

use crate::{
    learning::{
        checkpoint::{LoadError, model_bytes},
        settings::Settings,
        training::{Plan, Training},
    },
    run::RunDirectory,
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
            // A panic there was told of when it happened, and what it has not written is written at
            // the training's end.
            let _ = thread.join();
        }
    }
}
