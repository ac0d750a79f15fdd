//! Saving a training while it goes on.

use std::{
    sync::mpsc::{SyncSender, sync_channel},
    thread::{Builder, JoinHandle},
};

use anyhow::Context;

use crate::{
    learning::{checkpoint::model_bytes, training::Training},
    run::RunDirectory,
};

/// Writes `episodes.csv`, the model and the checkpoint of a training.
pub fn write(training: &Training, directory: &RunDirectory) -> anyhow::Result<()> {
    directory.write_episodes(&training.progress.records)?;
    directory.write(RunDirectory::MODEL, &model_bytes(training.learner().network())?)?;
    // Last, so that a checkpoint never knows more than the files beside it.
    directory.write_by(RunDirectory::CHECKPOINT, |path| Ok(training.write_checkpoint(path)?))?;
    Ok(())
}

/// A thread that writes copies of a training, so that the learner does not wait for the disk.
pub struct Saver {
    /// None once the thread shall end.
    trainings: Option<SyncSender<Training>>,
    thread: Option<JoinHandle<anyhow::Result<()>>>,
}

impl Saver {
    /// Starts the thread.
    pub fn start(directory: &RunDirectory) -> anyhow::Result<Saver> {
        // None waits in line: where the disk is slower than the training, the training waits.
        let (trainings, next) = sync_channel::<Training>(0);
        let directory = directory.clone();
        let write = move || next.iter().try_for_each(|training| write(&training, &directory));
        let thread = Builder::new().name("saver".into()).spawn(write);
        let thread = Some(thread.context("no thread to save the training")?);
        Ok(Saver { trainings: Some(trainings), thread })
    }

    /// Saves a training. An error may be that of the copy before.
    pub fn save(&mut self, training: &Training) -> anyhow::Result<()> {
        let copy = training.clone();
        let is_sent = self.trainings.as_ref().is_some_and(|line| line.send(copy).is_ok());
        if is_sent { Ok(()) } else { self.finish() }
    }

    /// Waits until everything is written.
    fn finish(&mut self) -> anyhow::Result<()> {
        self.trainings = None;
        let written = self.thread.take().map(JoinHandle::join);
        written
            .unwrap_or(Ok(Ok(())))
            .unwrap_or_else(|_| anyhow::bail!("the saving thread panicked"))
    }
}

impl Drop for Saver {
    fn drop(&mut self) {
        // The training's end is written after this, and meets the same errors.
        let _ = self.finish();
    }
}
