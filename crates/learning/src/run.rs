//! The directory of a run: every file appears whole or not at all.

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

/// A directory that a training or a test leaves its files in.
#[derive(Clone, Debug)]
pub struct RunDirectory {
    path: PathBuf,
}

/// What a file's name ends with while it is written.
const UNFINISHED: &str = ".unfinished";

/// Why a file was not written; what was there before is still there.
#[derive(Debug, Error)]
#[error("could not write {path}: {reason}")]
pub struct WriteError {
    path: PathBuf,
    reason: String,
}

/// `summary.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// The scenario of the training.
    pub scenario: String,
    /// The preset.
    pub preset: String,
    /// The seed of the run.
    pub seed: u64,
    /// Training episodes.
    pub episodes: u32,
    /// Steps of all of them.
    pub steps: u64,
    /// From the first reset request to the last update, in seconds.
    pub wall_s: f64,
    /// `steps / wall_s`
    pub steps_per_s: f64,
    /// Mean time of an update in microseconds.
    pub update_us: f64,
    /// The test of the trained policy.
    pub evaluation: Option<Evaluation>,
}

impl RunDirectory {
    /// Names of the files that make a directory a training's.
    pub const CHECKPOINT: &str = "checkpoint.safetensors";
    /// The checkpoint before that one.
    pub const PREVIOUS_CHECKPOINT: &str = "checkpoint.previous.safetensors";
    /// What was to be the last checkpoint.
    pub const DAMAGED_CHECKPOINT: &str = "checkpoint.damaged.safetensors";
    /// The weights alone.
    pub const MODEL: &str = "model.safetensors";
    /// Every resolved parameter of both nodes.
    pub const CONFIG: &str = "config.yaml";

    /// A directory as it is; it is made if it does not exist.
    pub fn open(path: &Path) -> Result<RunDirectory, WriteError> {
        fs::create_dir_all(path).map_err(|error| write_error(path, error))?;
        Ok(RunDirectory { path: path.to_owned() })
    }

    /// An empty directory. What an earlier run left there is kept under another name, which is
    /// returned.
    pub fn create(path: &Path) -> Result<(RunDirectory, Option<PathBuf>), WriteError> {
        let checkpoints = [RunDirectory::CHECKPOINT, RunDirectory::PREVIOUS_CHECKPOINT];
        if !checkpoints.iter().any(|name| path.join(name).exists()) {
            return Ok((RunDirectory::open(path)?, None));
        }
        // Without what a shell's completion or a dot leaves at the end of a path.
        let whole = fs::canonicalize(path).map_err(|error| write_error(path, error))?;
        let aside = (1..)
            .map(|number| {
                let mut name = whole.clone().into_os_string();
                name.push(format!(".{number}"));
                PathBuf::from(name)
            })
            .find(|candidate| !candidate.exists())
            .expect("there are more numbers than directories");
        fs::rename(&whole, &aside).map_err(|error| write_error(&aside, error))?;
        Ok((RunDirectory::open(&whole)?, Some(aside)))
    }

    /// The path of a file of the run.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes a file: a temporary one beside it first, which then takes its name.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), WriteError> {
        self.write_by(name, |path| Ok(fs::write(path, bytes)?))
    }

    /// As [`RunDirectory::write`], by a function that writes to a path or replaces what is there.
    pub fn write_by(
        &self,
        name: &str,
        write: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> Result<(), WriteError> {
        self.replace(name, None, write)
    }

    /// As [`RunDirectory::write_by`], but what was there before is kept under another name: at any
    /// moment one of the two has it.
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
            // Always the same name: what a killed agent leaves behind is in nobody's way for long.
            match fs::remove_file(self.file(&format!("{name}{UNFINISHED}"))) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
                _ => {}
            }
            // As any other file: for whomever the umask leaves it to.
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
            // The name is part of the directory, which has to reach the disk, too.
            Ok(fs::File::open(&self.path)?.sync_all()?)
        };
        write().map_err(|error| write_error(&target, error))
    }

    /// Writes a value as indented JSON.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), WriteError> {
        let json =
            serde_json::to_vec_pretty(value).map_err(|e| write_error(&self.file(name), e))?;
        self.write(name, &[json, b"\n".to_vec()].concat())
    }

    /// Writes `episodes.csv`.
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

    /// Writes `config.yaml`: the parameters of several nodes, as a file for `--params-file`.
    pub fn write_config<V: Serialize>(
        &self,
        nodes: &BTreeMap<String, BTreeMap<String, V>>,
    ) -> Result<(), WriteError> {
        let sections: BTreeMap<String, BTreeMap<&str, &BTreeMap<String, V>>> = nodes
            .iter()
            // In whatever namespace the nodes stand.
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
    fn an_earlier_run_is_kept_whatever_its_path_looks_like() {
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
    fn what_is_replaced_can_be_kept() {
        let home = tempfile::tempdir().unwrap();
        let run = RunDirectory::open(home.path()).unwrap();
        for bytes in [b"one", b"two"] {
            run.write_and_keep("file", "before", |path| Ok(fs::write(path, bytes)?)).unwrap();
        }
        assert_eq!(fs::read(run.file("file")).unwrap(), b"two");
        assert_eq!(fs::read(run.file("before")).unwrap(), b"one");
        // What cannot be written replaces nothing.
        run.write_and_keep("file", "before", |_| anyhow::bail!("no")).unwrap_err();
        assert_eq!(fs::read(run.file("file")).unwrap(), b"two");
        assert_eq!(fs::read(run.file("before")).unwrap(), b"one");
    }

    #[test]
    fn what_a_killed_run_left_unfinished_does_not_stay() {
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
    fn a_file_that_cannot_be_written_leaves_what_was_there() {
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
