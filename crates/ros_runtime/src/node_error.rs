//! Why a node, or one of its topics or services, cannot be made.

use thiserror::Error;

use crate::{
    discovery::DiscoveryError,
    logging::InvalidColorization,
    names::InvalidName,
    parameters::{ParameterError, ParameterFileError},
    rmw::UnknownRmw,
};

/// Why a node cannot be made, or not have one of its topics or services.
#[derive(Debug, Error)]
pub enum NodeError {
    /// The environment is wrong, or DDS does not start.
    #[error(transparent)]
    Discovery(#[from] DiscoveryError),
    /// The console cannot be written as wanted.
    #[error(transparent)]
    Logging(#[from] InvalidColorization),
    /// The middleware is none that can be spoken with.
    #[error(transparent)]
    Rmw(#[from] UnknownRmw),
    /// A name is none.
    #[error(transparent)]
    Name(#[from] InvalidName),
    /// A parameter file cannot be used.
    #[error(transparent)]
    ParameterFile(#[from] ParameterFileError),
    /// A parameter that every node has is wrong.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// What describes the node's types is no definition.
    #[error("a definition is wrong: {0}")]
    Definition(#[from] rosidl::DefinitionError),
    /// The operating system refuses threads or signals.
    #[error("could not start the node's runtime: {0}")]
    Runtime(#[from] std::io::Error),
    /// DDS refuses an endpoint.
    #[error("could not create {what}: {reason}")]
    Endpoint {
        /// The node, topic or service.
        what: String,
        /// What DDS says.
        reason: String,
    },
}

pub(crate) fn endpoint<E: std::fmt::Display>(what: &str) -> impl FnOnce(E) -> NodeError {
    let what = what.to_owned();
    move |error| NodeError::Endpoint { what, reason: error.to_string() }
}
