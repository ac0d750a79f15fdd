//! Why a simulator does not do what is asked of it.

use std::num::NonZeroU64;

use ros_runtime::service::CallError;
use thiserror::Error;

use crate::background::ThreadEnded;

/// Why a simulator does not do what is asked of it.
#[derive(Debug, Error)]
pub enum SimulatorError {
    /// The program ends.
    #[error("the node is shutting down")]
    Shutdown,
    /// Another client has reset the simulator.
    #[error("another client has taken over the simulator: {0}")]
    TakenOver(String),
    /// The simulator refuses what it is asked.
    #[error("the simulator refuses: {0}")]
    Refused(String),
    /// The simulator cannot be reached.
    #[error(transparent)]
    Unreachable(CallError),
    /// What came back is no image of the camera.
    #[error("the simulator sent {0}")]
    BadImage(String),
    /// There is no episode to take a step in.
    #[error("no episode has begun: a reset has to come before a step")]
    NoEpisode,
    /// After a restart the room is not what it was.
    #[error(
        "the simulator does not repeat itself: step {step} of the episode with seed {seed} shows \
         another image than before; was it started with other parameters?"
    )]
    NotRepeatable {
        /// The step, 0 for the reset.
        step: usize,
        /// The episode's seed.
        seed: NonZeroU64,
    },
    /// The thread that speaks with the simulator is gone.
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
