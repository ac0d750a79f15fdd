//! A service client that gets its answer although single messages are lost.
//!
//! DDS repeats a lost sample, but not one that was written before reader and writer had found each
//! other, nor one that died with its process. So a request is sent again until its answer comes or
//! its deadline passes. That is safe for services that recognise a repeated request.

use std::time::Duration;

use evac_msgs::RosService;
use log::{debug, warn};
use ros2_client::{Client, error::WriteError};
use rustdds::DomainParticipant;
use thiserror::Error;
use tokio::time::{Instant, sleep, timeout_at};

use crate::shutdown::Shutdown;

/// The first wait for an answer; each further one is twice as long, up to [`LONGEST_WAIT`].
const FIRST_WAIT: Duration = Duration::from_millis(250);
/// The longest wait before a request is repeated.
const LONGEST_WAIT: Duration = Duration::from_secs(2);
/// The wait before a request is sent that found no room in the send window.
const SEND_RETRY: Duration = Duration::from_millis(10);

/// Why a call has no answer.
#[derive(Debug, Error, PartialEq)]
pub enum CallError {
    /// Nobody answered in time.
    #[error("no answer from the service {service} within {seconds:.1} s: is its node running?")]
    Deadline {
        /// The service.
        service: String,
        /// How long the call waited.
        seconds: f64,
    },
    /// The answer cannot be read.
    #[error("the service {service} sent an answer that cannot be read: {reason}")]
    Unreadable {
        /// The service.
        service: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The request cannot be sent.
    #[error("the request to the service {service} cannot be sent: {reason}")]
    Unsendable {
        /// The service.
        service: String,
        /// Why not.
        reason: String,
    },
    /// The node ends.
    #[error("the node is shutting down")]
    Shutdown,
}

/// The client of a service.
pub struct ServiceClient<S: RosService> {
    pub(crate) name: String,
    pub(crate) client: Client<S::Request, S::Response>,
    pub(crate) participant: DomainParticipant,
    pub(crate) shutdown: Shutdown,
}

impl<S: RosService> ServiceClient<S> {
    /// The absolute name of the service.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether a server is there now.
    pub fn is_ready(&self) -> bool {
        // The topic of requests, as rmw names it.
        let topic = format!("rq{}Request", self.name);
        let readers = self.participant.discovered_readers();
        readers.iter().any(|reader| *reader.subscription_topic_data.topic_name() == topic)
    }

    /// Asks until there is an answer, at most until the deadline.
    pub async fn call(
        &self,
        request: S::Request,
        deadline: Option<Duration>,
    ) -> Result<S::Response, CallError> {
        let answer = self.call_until(request, deadline);
        self.shutdown.unless_requested(answer).await.unwrap_or(Err(CallError::Shutdown))
    }

    async fn call_until(
        &self,
        request: S::Request,
        deadline: Option<Duration>,
    ) -> Result<S::Response, CallError> {
        let start = Instant::now();
        let mut wait = FIRST_WAIT;
        loop {
            let attempt = self.attempt(request.clone());
            let end = match deadline {
                Some(deadline) => (Instant::now() + wait).min(start + deadline),
                None => Instant::now() + wait,
            };
            if let Ok(result) = timeout_at(end, attempt).await {
                return result;
            }
            if let Some(deadline) = deadline.filter(|deadline| start.elapsed() >= *deadline) {
                let seconds = deadline.as_secs_f64();
                return Err(CallError::Deadline { service: self.name.clone(), seconds });
            }
            let waited = start.elapsed().as_secs_f64();
            // The first repetition is everyday life while the two sides find each other.
            if wait < LONGEST_WAIT {
                debug!("no answer from {} for {waited:.1} s: asking again", self.name);
            } else {
                warn!("no answer from {} for {waited:.1} s: asking again", self.name);
            }
            wait = (wait * 2).min(LONGEST_WAIT);
        }
    }

    async fn attempt(&self, request: S::Request) -> Result<S::Response, CallError> {
        let id = loop {
            match self.client.async_send_request(request.clone()).await {
                Ok(id) => break id,
                // The send window is full of what a reader that went away never acknowledged.
                Err(WriteError::WouldBlock { .. }) => sleep(SEND_RETRY).await,
                Err(error) => {
                    let (service, reason) = (self.name.clone(), error.to_string());
                    return Err(CallError::Unsendable { service, reason });
                }
            }
        };
        self.client.async_receive_response(id).await.map_err(|error| CallError::Unreadable {
            service: self.name.clone(),
            reason: error.to_string(),
        })
    }
}
