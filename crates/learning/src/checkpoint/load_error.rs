//! Why a checkpoint or a model cannot be used.

use std::path::Path;

use thiserror::Error;

/// Why a file of tensors cannot be used.
#[derive(Debug, Error)]
pub enum LoadError {
    /// The file cannot be read.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is damaged or something else.
    #[error("{path} is damaged or no safetensors file: {reason}")]
    Damaged {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The file is of a training with other settings.
    #[error("{path} does not fit: {reason}")]
    DoesNotFit {
        /// The file.
        path: String,
        /// What does not fit.
        reason: String,
    },
}

pub(super) fn damaged(path: &Path, reason: impl ToString) -> LoadError {
    LoadError::Damaged { path: path.display().to_string(), reason: reason.to_string() }
}

pub(super) fn does_not_fit(path: &Path, reason: impl ToString) -> LoadError {
    LoadError::DoesNotFit { path: path.display().to_string(), reason: reason.to_string() }
}
