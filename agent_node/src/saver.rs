//! Saving a training while it goes on.

use std::{
    sync::mpsc::{SyncSender, sync_channel},
    thread::{Builder, JoinHandle},
};

use anyhow::Context;

use crate::{
    learning::{checkpoint::model_bytes, record::EpisodeRecord, training::Training},
    run::RunDirectory,
};

/// A training as it was at one moment.
pub struct Snapshot {
    records: Vec<EpisodeRecord>,
    model: Vec<u8>,
    checkpoint: Vec<u8>,
}

impl Snapshot {
    /// A training as it is now.
    pub fn of(training: &Training) -> anyhow::Result<Snapshot> {
        Ok(Snapshot {
            records: training.progress.records.clone(),
            model: model_bytes(training.learner().network())?,
            checkpoint: training.checkpoint_bytes()?,
        })
    }

    /// Writes `episodes.csv`, the model and the checkpoint.
    pub fn write(&self, directory: &RunDirectory) -> anyhow::Result<()> {
        directory.write_episodes(&self.records)?;
        directory.write(RunDirectory::MODEL, &self.model)?;
        // Last, so that a checkpoint never knows more than the files beside it.
        directory.write(RunDirectory::CHECKPOINT, &self.checkpoint)?;
        Ok(())
    }
}

/// A thread that writes snapshots, so that the learner does not wait for the disk.
pub struct Saver {
    /// None once the thread shall end.
    snapshots: Option<SyncSender<Snapshot>>,
    thread: Option<JoinHandle<anyhow::Result<()>>>,
}

impl Saver {
    /// Starts the thread.
    pub fn start(directory: &RunDirectory) -> anyhow::Result<Saver> {
        // None waits in line: where the disk is slower than the training, the training waits.
        let (snapshots, next) = sync_channel::<Snapshot>(0);
        let directory = directory.clone();
        let write = move || next.iter().try_for_each(|snapshot| snapshot.write(&directory));
        let thread = Builder::new().name("saver".into()).spawn(write);
        let thread = Some(thread.context("no thread to save the training")?);
        Ok(Saver { snapshots: Some(snapshots), thread })
    }

    /// Saves a training. An error may be that of the snapshot before.
    pub fn save(&mut self, training: &Training) -> anyhow::Result<()> {
        let snapshot = Snapshot::of(training)?;
        let is_sent = self.snapshots.as_ref().is_some_and(|line| line.send(snapshot).is_ok());
        if is_sent { Ok(()) } else { self.finish() }
    }

    /// Waits until everything is written.
    fn finish(&mut self) -> anyhow::Result<()> {
        self.snapshots = None;
        let written = self.thread.take().map(JoinHandle::join);
        written
            .unwrap_or(Ok(Ok(())))
            .unwrap_or_else(|_| anyhow::bail!("the saving thread panicked"))
    }
}

impl Drop for Saver {
    fn drop(&mut self) {
        // The training's last snapshot is written after this, and meets the same errors.
        let _ = self.finish();
    }
}
