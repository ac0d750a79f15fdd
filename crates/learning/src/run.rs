//! The directory of a run, whose files are replaced atomically.

use std::{
    collections::BTreeMap,
    fs, io,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use task::Evaluation;

use crate::record::Records;

/// The directory of a training run or an evaluation.
///
/// Each file is written under a temporary name, synced to disk and renamed, so a crash or a power
/// failure never leaves it partially written.
///
/// # Examples
///
/// ```
/// use learning::run::RunDirectory;
///
/// let home = tempfile::tempdir()?;
/// let (run, previous) = RunDirectory::create(&home.path().join("run"))?;
/// assert_eq!(previous, None);
/// run.write(RunDirectory::MODEL, b"weights")?;
/// assert_eq!(std::fs::read(run.file(RunDirectory::MODEL))?, b"weights");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct RunDirectory {
    path: PathBuf,
}

/// The suffix of a file that is being written.
const UNFINISHED: &str = ".unfinished";

/// The error for a file or directory that could not be written.
#[derive(Debug, Error)]
#[error("could not write {path}: {reason}")]
pub struct WriteError {
    path: PathBuf,
    reason: String,
}

/// The contents of `summary.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// The training scenario.
    pub scenario: String,
    /// The name of the preset.
    pub preset: String,
    /// The seed of the run.
    pub seed: u64,
    /// Number of training episodes.
    pub episodes: u32,
    /// Total number of steps in all training episodes.
    pub steps: u64,
    /// Wall time from the first reset to the last update, in seconds.
    pub wall_s: f64,
    /// `steps / wall_s`
    pub steps_per_s: f64,
    /// Mean update time in microseconds.
    pub update_us: f64,
    /// The evaluation of the trained policy, if it was evaluated.
    pub evaluation: Option<Evaluation>,
}

impl RunDirectory {
    /// File name of the latest checkpoint.
    pub const CHECKPOINT: &str = "checkpoint.safetensors";
    /// File name of the previous checkpoint.
    pub const PREVIOUS_CHECKPOINT: &str = "checkpoint.previous.safetensors";
    /// File name under which a damaged checkpoint is kept.
    pub const DAMAGED_CHECKPOINT: &str = "checkpoint.damaged.safetensors";
    /// File name of the trained network.
    pub const MODEL: &str = "model.safetensors";
    /// File name of the YAML file with the resolved parameters of both nodes.
    pub const CONFIG: &str = "config.yaml";

    /// Opens a directory, creating it if it does not exist.
    ///
    /// # Errors
    ///
    /// Returns an error if the directory cannot be created.
    pub fn open(path: &Path) -> Result<RunDirectory, WriteError> {
        fs::create_dir_all(path).map_err(|error| write_error(path, error))?;
        Ok(RunDirectory { path: path.to_owned() })
    }

    /// Creates the directory of a new run.
    ///
    /// If the directory contains a checkpoint from an earlier run, the directory is first renamed
    /// to `PATH.N`, where `N` is the first free number, and the new path is returned.
    ///
    /// # Errors
    ///
    /// Returns an error if a directory cannot be created or renamed.
    pub fn create(path: &Path) -> Result<(RunDirectory, Option<PathBuf>), WriteError> {
        let checkpoints = [RunDirectory::CHECKPOINT, RunDirectory::PREVIOUS_CHECKPOINT];
        if !checkpoints.iter().any(|name| path.join(name).exists()) {
            return Ok((RunDirectory::open(path)?, None));
        }
        // Removes a trailing slash or dot, to which no suffix can be added.
        let canonical = fs::canonicalize(path).map_err(|error| write_error(path, error))?;
        let aside = (1..)
            .map(|number| {
                let mut name = canonical.clone().into_os_string();
                name.push(format!(".{number}"));
                PathBuf::from(name)
            })
            .find(|candidate| !candidate.exists())
            .expect("there are fewer directories than numbers");
        fs::rename(&canonical, &aside).map_err(|error| write_error(&aside, error))?;
        Ok((RunDirectory::open(&canonical)?, Some(aside)))
    }

    /// Returns the path of a file in the directory.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes or replaces a file atomically.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be written. The file is never left partially written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), WriteError> {
        self.write_by(name, |path| Ok(fs::write(path, bytes)?))
    }

    /// Like [`write`](RunDirectory::write), but the file is written by the given function, which
    /// receives a temporary path.
    ///
    /// # Errors
    ///
    /// Returns an error if `write` fails, or if the file cannot be synced or renamed. The file is
    /// never left partially written.
    pub fn write_by(
        &self,
        name: &str,
        write: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> Result<(), WriteError> {
        self.replace(name, None, write)
    }

    /// Like [`write_by`](RunDirectory::write_by), but keeps the previous file as `previous`. At any
    /// time, at least one of the two files is complete.
    ///
    /// # Errors
    ///
    /// Returns an error if `write` fails, or if a file cannot be synced or renamed.
    pub fn write_and_keep(
        &self,
        name: &str,
        previous: &str,
        write: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> Result<(), WriteError> {
        self.replace(name, Some(previous), write)
    }

    fn replace(
        &self,
        name: &str,
        previous: Option<&str>,
        write: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> Result<(), WriteError> {
        let target = self.file(name);
        let write = || -> anyhow::Result<()> {
            // The temporary name is fixed, so the next write removes what a killed process left
            // behind.
            match fs::remove_file(self.file(&format!("{name}{UNFINISHED}"))) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
                _ => {}
            }
            // The umask applies to this mode; by default, tempfile creates private files.
            let permissions = fs::Permissions::from_mode(0o666);
            let temporary = tempfile::Builder::new()
                .prefix(name)
                .rand_bytes(0)
                .suffix(UNFINISHED)
                .permissions(permissions)
                .tempfile_in(&self.path)?
                .into_temp_path();
            let permissions = fs::metadata(&temporary)?.permissions();
            write(&temporary)?;
            fs::set_permissions(&temporary, permissions)?;
            fs::File::open(&temporary)?.sync_all()?;
            if let Some(previous) = previous.filter(|_| target.exists()) {
                fs::rename(&target, self.file(previous))?;
            }
            temporary.persist(&target)?;
            // Syncing the directory writes the rename to disk.
            Ok(fs::File::open(&self.path)?.sync_all()?)
        };
        write().map_err(|error| write_error(&target, error))
    }

    /// Writes a value as indented JSON.
    ///
    /// # Errors
    ///
    /// Returns an error if the value cannot be serialized or the file cannot be written.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), WriteError> {
        let json =
            serde_json::to_vec_pretty(value).map_err(|e| write_error(&self.file(name), e))?;
        self.write(name, &[json, b"\n".to_vec()].concat())
    }

    /// Writes the records of a training run as `episodes.csv`.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be written.
    pub fn write_episodes(&self, records: &Records) -> Result<(), WriteError> {
        const NAME: &str = "episodes.csv";
        let columns = ["episode", "steps", "return", "epsilon", "loss", "blocked", "terminated"];
        self.write_by(NAME, |path| {
            let mut writer = csv::WriterBuilder::new().has_headers(false).from_path(path)?;
            writer.write_record(columns)?;
            records.iter().try_for_each(|record| writer.serialize(record))?;
            Ok(writer.flush()?)
        })
    }

    /// Writes one line per row to a CSV file, after a line with the names of the fields.
    ///
    /// # Errors
    ///
    /// Returns an error if a row cannot be serialized or the file cannot be written.
    pub fn write_csv(&self, name: &str, rows: &[impl Serialize]) -> Result<(), WriteError> {
        self.write_by(name, |path| {
            let mut writer = csv::Writer::from_path(path)?;
            rows.iter().try_for_each(|row| writer.serialize(row))?;
            Ok(writer.flush()?)
        })
    }

    /// Writes `config.yaml`: the node parameters, keyed by node and parameter name, in the format
    /// of `--params-file`.
    ///
    /// # Errors
    ///
    /// Returns an error if the parameters cannot be serialized or the file cannot be written.
    pub fn write_config<V: Serialize>(
        &self,
        nodes: &BTreeMap<String, BTreeMap<String, V>>,
    ) -> Result<(), WriteError> {
        let sections: BTreeMap<String, BTreeMap<&str, &BTreeMap<String, V>>> = nodes
            .iter()
            // The wildcard matches the nodes in any namespace.
            .map(|(node, values)| {
                (format!("/**/{node}"), BTreeMap::from([("ros__parameters", values)]))
            })
            .collect();
        let path = self.file(RunDirectory::CONFIG);
        let yaml = serde_saphyr::to_string(&sections).map_err(|error| write_error(&path, error))?;
        self.write(RunDirectory::CONFIG, yaml.as_bytes())
    }
}

fn write_error(path: &Path, reason: impl ToString) -> WriteError {
    WriteError { path: path.to_owned(), reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_an_earlier_run_for_any_form_of_its_path() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("it's one");
        for (number, path) in [(1, path.clone()), (2, path.join("")), (3, path.join("."))] {
            let (run, kept) = RunDirectory::create(&path).unwrap();
            assert_eq!(kept.is_some(), number > 1);
            run.write(RunDirectory::CHECKPOINT, &[number]).unwrap();
        }
        for (name, number) in [("it's one", 3), ("it's one.1", 1), ("it's one.2", 2)] {
            let file = home.path().join(name).join(RunDirectory::CHECKPOINT);
            assert_eq!(fs::read(file).unwrap(), [number]);
        }
    }

    #[test]
    fn keeps_the_previous_file() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::open(home.path()).unwrap();
        for bytes in [b"one", b"two"] {
            run.write_and_keep("file", "before", |path| Ok(fs::write(path, bytes)?)).unwrap();
        }
        assert_eq!(fs::read(run.file("file")).unwrap(), b"two");
        assert_eq!(fs::read(run.file("before")).unwrap(), b"one");
        // A failed write changes neither file.
        run.write_and_keep("file", "before", |_| anyhow::bail!("no")).unwrap_err();
        assert_eq!(fs::read(run.file("file")).unwrap(), b"two");
        assert_eq!(fs::read(run.file("before")).unwrap(), b"one");
    }

    #[test]
    fn replaces_an_unfinished_file_left_by_a_killed_process() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::open(home.path()).unwrap();
        let unfinished = run.file(&format!("file{UNFINISHED}"));
        fs::write(&unfinished, b"half").unwrap();
        let write = |path: &Path| {
            assert_eq!(path, unfinished);
            Ok(fs::write(path, b"after")?)
        };
        run.write_by("file", write).unwrap();
        let names: Vec<_> =
            fs::read_dir(home.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(names, ["file"]);
        assert_eq!(fs::read(run.file("file")).unwrap(), b"after");
    }

    #[test]
    fn a_failed_write_leaves_other_files_unchanged() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::open(home.path()).unwrap();
        run.write("file", b"before").unwrap();
        // A directory cannot be replaced by a file.
        fs::create_dir(run.file("taken")).unwrap();
        let message = run.write("taken", b"after").unwrap_err().to_string();
        assert!(message.starts_with("could not write ") && message.contains("taken"), "{message}");
        let names: Vec<_> =
            fs::read_dir(home.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(names.len(), 2, "{names:?}");
    }
}
