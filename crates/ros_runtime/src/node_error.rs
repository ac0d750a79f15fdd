//! The error returned when a node cannot start or an endpoint cannot be created.

use thiserror::Error;

use crate::{
    discovery::DiscoveryError,
    escape::escaped,
    logging::InvalidColorization,
    names::InvalidName,
    parameters::{ParameterError, ParameterFileError},
    rmw::UnknownRmw,
};

/// The error returned when a node cannot start or an endpoint cannot be created.
///
/// # Examples
///
/// ```
/// use ros_runtime::{Arguments, Node, node::NodeError};
///
/// let line = ["camera", "--ros-args", "-p", "use_sim_time:=maybe"];
/// let arguments = Arguments::parse(line.map(str::to_owned))?;
/// let error = Node::parameters_only("camera", &arguments).unwrap_err();
/// assert!(matches!(error, NodeError::Parameter(_)));
/// # Ok::<(), ros_runtime::arguments::ArgumentsError>(())
/// ```
#[derive(Debug, Error)]
pub enum NodeError {
    /// An environment variable is invalid, or DDS fails to start.
    #[error(transparent)]
    Discovery(#[from] DiscoveryError),
    /// `RCUTILS_COLORIZED_OUTPUT` is invalid.
    #[error(transparent)]
    Logging(#[from] InvalidColorization),
    /// The middleware is not supported.
    #[error(transparent)]
    Rmw(#[from] UnknownRmw),
    /// A name is invalid.
    #[error(transparent)]
    Name(#[from] InvalidName),
    /// A parameter file cannot be read or is invalid.
    #[error(transparent)]
    ParameterFile(#[from] ParameterFileError),
    /// A parameter that every node has is invalid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// An interface definition is invalid.
    #[error("invalid interface definition: {0}")]
    Definition(#[from] rosidl::DefinitionError),
    /// The operating system cannot start threads or install signal handlers.
    #[error("could not start the node's runtime: {0}")]
    Runtime(#[from] std::io::Error),
    /// DDS rejects the node or an endpoint.
    #[error("could not create {what}: {}", escaped(.reason))]
    Endpoint {
        /// The node, topic or service.
        what: String,
        /// The error reported by DDS.
        reason: String,
    },
}

/// Returns a function that wraps a DDS error, for `map_err`.
pub(crate) fn endpoint<E: std::fmt::Display>(what: &str) -> impl FnOnce(E) -> NodeError {
    let what = what.to_owned();
    move |error| NodeError::Endpoint { what, reason: error.to_string() }
}
