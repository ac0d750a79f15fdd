//! What can be wrong with definitions.

use std::{io, path::PathBuf};

use thiserror::Error;

/// Why a text is no definition.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum DefinitionError {
    /// The size of an array or of a string is no number.
    #[error("'{written}' has the size '{size}': expected a whole number")]
    Size {
        /// The type.
        written: String,
        /// Its size.
        size: String,
    },
    /// A line is neither a field nor a constant.
    #[error("'{0}' is neither a field, TYPE NAME, nor a constant, TYPE NAME=VALUE")]
    Line(String),
    /// A name has no package or kind.
    #[error("'{0}' is no name of a type: expected PACKAGE/msg/NAME or PACKAGE/srv/NAME")]
    Name(String),
}

/// Why nothing is written.
#[derive(Debug, Error)]
pub enum GenerateError {
    /// A directory or a file cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A definition is wrong.
    #[error("{name}: {source}")]
    Definition {
        /// The full name of what it defines.
        name: String,
        /// What is wrong with it.
        source: DefinitionError,
    },
    /// A type that a field has is not defined.
    #[error(
        "{name}: its field '{field}' is a {missing}, which is not defined: is its package missing?"
    )]
    Missing {
        /// The full name of the message.
        name: String,
        /// The field.
        field: String,
        /// The full name of the type.
        missing: String,
    },
    /// Something that is in the language, but not written as Rust.
    #[error("{name}: '{what}' is not supported")]
    Unsupported {
        /// The full name of the message.
        name: String,
        /// What is not.
        what: String,
    },
}
