//! The error of [`Simulator`](super::Simulator).

use std::num::NonZeroU64;

use ros_runtime::service::CallError;
use thiserror::Error;

use crate::background::ThreadEnded;

/// The error for a failed reset or step over DDS, or for an invalid image.
#[derive(Debug, Error)]
pub enum SimulatorError {
    /// The node is shutting down.
    #[error("the node is shutting down")]
    Shutdown,
    /// Another client has reset the environment or controls the robot through `/action`.
    #[error("another client has taken over the environment: {0}")]
    TakenOver(String),
    /// The environment refused the request, with this status and message.
    #[error("the environment refused the request: {0}")]
    Refused(String),
    /// The service call failed, for example after a timeout.
    #[error(transparent)]
    Unreachable(CallError),
    /// The image is not a 20 x 7 image with the encoding `rgb8`.
    #[error("{0}")]
    BadImage(String),
    /// A step was requested before an episode had begun.
    #[error("no episode has begun: call reset before step")]
    NoEpisode,
    /// A restarted environment returned a different image when the episode was replayed.
    #[error(
        "the environment is not reproducible: step {step} of the episode with seed {seed} returned \
         a different image than before the restart (was it restarted with other parameters?)"
    )]
    NotReproducible {
        /// The number of the step, from 1; 0 for the reset.
        step: usize,
        /// The seed of the episode.
        seed: NonZeroU64,
    },
    /// The thread that runs the environment has ended.
    #[error(transparent)]
    ThreadEnded(#[from] ThreadEnded),
}

impl From<CallError> for SimulatorError {
    fn from(error: CallError) -> SimulatorError {
        match error {
            CallError::Shutdown => SimulatorError::Shutdown,
            other => SimulatorError::Unreachable(other),
        }
    }
}
