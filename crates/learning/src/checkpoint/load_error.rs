//! Errors that occur when loading a checkpoint or a model.

use std::path::Path;

use thiserror::Error;

/// The error for a checkpoint or a model that cannot be used.
#[derive(Debug, Error)]
pub enum LoadError {
    /// The file cannot be read, or a damaged checkpoint cannot be renamed.
    #[error("{path}: {source}")]
    Read {
        /// The path of the file.
        path: String,
        /// The operating system error.
        source: std::io::Error,
    },
    /// The file is damaged, or is not a checkpoint or model.
    #[error("{path} is damaged or not a safetensors file: {reason}")]
    Damaged {
        /// The path of the file.
        path: String,
        /// A description of what is invalid.
        reason: String,
    },
    /// The file has a different format version, or does not match the plan or the settings.
    #[error("{path} does not match this run: {reason}")]
    Mismatch {
        /// The path of the file.
        path: String,
        /// A description of what differs.
        reason: String,
    },
}

pub(super) fn damaged(path: &Path, reason: impl ToString) -> LoadError {
    LoadError::Damaged { path: path.display().to_string(), reason: reason.to_string() }
}

pub(super) fn mismatch(path: &Path, reason: impl ToString) -> LoadError {
    LoadError::Mismatch { path: path.display().to_string(), reason: reason.to_string() }
}
