//! Saves a training run from a background thread, and loads saved runs.

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

/// Writes `episodes.csv`, `model.safetensors` and the checkpoint of a training run, and keeps the
/// previous checkpoint.
///
/// # Errors
///
/// Returns an error if a file cannot be written.
pub fn write(training: &Training, directory: &RunDirectory) -> anyhow::Result<()> {
    directory.write_episodes(&training.progress.records)?;
    directory.write(RunDirectory::MODEL, &model_bytes(training.learner().network())?)?;
    // The checkpoint is written last, so that it is never newer than the other files.
    directory.write_and_keep(
        RunDirectory::CHECKPOINT,
        RunDirectory::PREVIOUS_CHECKPOINT,
        |path| Ok(training.write_checkpoint(path)?),
    )?;
    Ok(())
}

/// Loads the training run from the latest checkpoint or, with a warning, from the previous one if
/// the latest is damaged or missing. A damaged checkpoint is renamed to
/// [`DAMAGED_CHECKPOINT`](RunDirectory::DAMAGED_CHECKPOINT).
///
/// # Errors
///
/// Returns an error if no checkpoint can be used, or if the latest one was saved with a different
/// plan or different settings.
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
            warn!("{error}; resuming from the previous checkpoint");
            // Without this rename, the next save would replace the only intact checkpoint with the
            // damaged one.
            let latest = directory.file(RunDirectory::CHECKPOINT);
            if latest.exists() {
                let aside = directory.file(RunDirectory::DAMAGED_CHECKPOINT);
                fs::rename(&latest, aside).map_err(|source| LoadError::Read {
                    path: latest.display().to_string(),
                    source,
                })?;
            }
            Ok(training)
        }
        // Without a previous checkpoint, report why the latest one cannot be loaded.
        Err(LoadError::Read { .. }) => Err(error),
        Err(previous) => {
            warn!("{error}");
            Err(previous)
        }
    }
}

/// A thread that saves copies of a training run, so that training does not wait for the disk.
///
/// Dropping the saver blocks until the last copy is written.
///
/// # Examples
///
/// ```
/// use learning::{
///     run::RunDirectory,
///     saver::{self, Saver},
///     settings::Preset,
///     training::{Plan, Training},
/// };
///
/// let home = tempfile::tempdir()?;
/// let run = RunDirectory::open(home.path())?;
/// let plan = Plan { scenario: "empty".into(), episodes: 10, seed: 1, rooms: 1 };
/// let settings = Preset::Paper.settings();
/// let training = Training::new(plan.clone(), settings.clone())?;
///
/// let background = Saver::start(&run)?;
/// background.save(&training)?;
/// drop(background);
/// let loaded = saver::load(&run, &plan, &settings)?;
/// assert_eq!(loaded.progress, training.progress);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub struct Saver {
    /// Set to `None` when the saver is dropped, which ends the thread.
    trainings: Option<SyncSender<Training>>,
    thread: Option<JoinHandle<()>>,
}

impl Saver {
    /// Starts the thread.
    ///
    /// # Errors
    ///
    /// Returns an error if the operating system cannot start a thread.
    pub fn start(directory: &RunDirectory) -> anyhow::Result<Saver> {
        // The channel has no queue, so training waits if the disk cannot keep up.
        let (trainings, next) = sync_channel::<Training>(0);
        let directory = directory.clone();
        let write = move || {
            for training in next {
                // Training continues: the next save may succeed, e.g. once the disk has free space.
                if let Err(error) = write(&training, &directory) {
                    warn!("{error:#}; training continues, and the next save will try again");
                }
            }
        };
        let thread = Builder::new().name("saver".into()).spawn(write);
        let thread = Some(thread.context("could not start the saver thread")?);
        Ok(Saver { trainings: Some(trainings), thread })
    }

    /// Saves a copy of a training run. Waits if the previous save is still in progress. If a file
    /// cannot be written, a warning is logged.
    ///
    /// # Errors
    ///
    /// Returns an error if the thread has ended.
    pub fn save(&self, training: &Training) -> anyhow::Result<()> {
        let is_sent =
            self.trainings.as_ref().is_some_and(|sender| sender.send(training.clone()).is_ok());
        anyhow::ensure!(is_sent, "the saver thread has ended");
        Ok(())
    }
}

impl Drop for Saver {
    /// Blocks until the last copy is written.
    fn drop(&mut self) {
        self.trainings = None;
        if let Some(thread) = self.thread.take() {
            // A panic in the thread has already been reported.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Preset;

    #[test]
    fn resumes_from_the_previous_checkpoint_if_the_latest_is_unusable() {
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

        let latest = run.file(RunDirectory::CHECKPOINT);
        let mut bytes = fs::read(&latest).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&latest, &bytes).unwrap();
        assert_eq!(load().unwrap().progress.total_steps, 0);
        // This is the state after a power failure between the two renames.
        assert!(!latest.exists());
        assert_eq!(load().unwrap().progress.total_steps, 0);
        // The next save keeps the intact checkpoint as the previous one.
        write(&training, &run).unwrap();
        fs::remove_file(&latest).unwrap();
        assert_eq!(load().unwrap().progress.total_steps, 0);

        // If both are damaged, the error for the previous one is returned.
        fs::write(&latest, &bytes).unwrap();
        fs::write(run.file(RunDirectory::PREVIOUS_CHECKPOINT), b"").unwrap();
        let message = load().unwrap_err().to_string();
        assert!(message.contains("checkpoint.previous.safetensors is damaged"), "{message}");

        // A checkpoint of another training run is not damaged, so the previous one is not tried.
        write(&training, &run).unwrap();
        let other = Plan { seed: 4, ..plan.clone() };
        assert!(matches!(super::load(&run, &other, &settings), Err(LoadError::Mismatch { .. })));
    }
}
