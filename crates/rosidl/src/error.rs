//! Errors in definitions and code generation.

use std::{io, path::PathBuf};

use thiserror::Error;

/// The error returned for an invalid definition.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum DefinitionError {
    /// The size of an array, a sequence or a string is not a whole number.
    #[error("invalid size '{size}' in type '{type_name}' (expected: a whole number)")]
    Size {
        /// The type as written in the definition.
        type_name: String,
        /// The invalid size.
        size: String,
    },
    /// A line is neither a field nor a constant.
    #[error("invalid line '{0}' (expected: field TYPE NAME or constant TYPE NAME=VALUE)")]
    Line(String),
    /// A full type name does not consist of a package, a kind (`msg` or `srv`) and a name.
    #[error("invalid type name '{0}' (expected: PACKAGE/msg/NAME or PACKAGE/srv/NAME)")]
    Name(String),
}

/// The error returned if code generation fails.
#[derive(Debug, Error)]
pub enum GenerateError {
    /// A directory or a file cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// The path of the directory or file.
        path: PathBuf,
        /// The I/O error.
        source: io::Error,
    },
    /// A definition is invalid.
    #[error("{name}: {source}")]
    Definition {
        /// The full name of the defined message or service.
        name: String,
        /// The error in the definition.
        source: DefinitionError,
    },
    /// The type of a field is not defined.
    #[error("{name}: field '{field}' has the undefined type {missing} (add its package)")]
    Missing {
        /// The full name of the message.
        name: String,
        /// The name of the field.
        field: String,
        /// The full name of the undefined type.
        missing: String,
    },
    /// A definition contains a valid construct for which this crate cannot generate Rust code.
    #[error("{name}: '{construct}' is not supported")]
    Unsupported {
        /// The full name of the message.
        name: String,
        /// The unsupported construct.
        construct: String,
    },
}
