//! A service client that gets its answer although single messages are lost.
//!
//! DDS repeats a lost sample, but not one that was written before reader and writer had found each
//! other, nor one that died with its process. So a request is sent again until its answer comes or
//! its deadline passes. That is safe for services that recognise a repeated request.

use std::{sync::Arc, time::Duration};

use log::{debug, info, warn};
use parking_lot::Mutex;
use ros_interfaces::RosService;
use ros2_client::{Client, Name, RmwRequestId, error::WriteError};
use thiserror::Error;
use tokio::{
    sync::watch,
    time::{Instant, sleep_until, timeout, timeout_at},
};

use crate::{latency::Latencies, qos::services, shared_node::SharedNode, shutdown::Shutdown};

/// The first wait for an answer while nobody knows how long one takes. Each further wait is twice as
/// long as the one before, up to [`LONGEST_WAIT`].
const FIRST_WAIT: Duration = Duration::from_millis(250);
/// The shortest first wait. A system that is busy may well hold an answer up for so long.
const SHORTEST_WAIT: Duration = Duration::from_millis(20);
/// The longest wait before a request is repeated. An answer that takes longer than that would come to
/// nobody: it is the repetition's that is waited for then.
const LONGEST_WAIT: Duration = Duration::from_secs(2);

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
    /// The DDS topic of the requests.
    pub(crate) request_topic: String,
    /// Made anew where the send window is full.
    pub(crate) client: Mutex<Arc<Client<S::Request, S::Response>>>,
    pub(crate) node: SharedNode,
    pub(crate) servers: watch::Receiver<usize>,
    pub(crate) latencies: Latencies,
    pub(crate) shutdown: Shutdown,
}

impl<S: RosService> ServiceClient<S> {
    /// The absolute name of the service.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many servers there are. One that was killed counts until DDS gives it up.
    pub fn servers(&self) -> usize {
        *self.servers.borrow()
    }

    /// How long the answers take.
    pub fn latencies(&self) -> &Latencies {
        &self.latencies
    }

    /// Waits until a server is there, at most until the deadline.
    pub async fn wait_until_ready(&self, deadline: Option<Duration>) -> Result<(), CallError> {
        let mut servers = self.servers.clone();
        let ready = async {
            if self.servers() == 0 {
                info!("waiting for the service {}", self.name);
            }
            // The sender lives as long as the node's graph.
            let _ = servers.wait_for(|servers| *servers > 0).await;
            Ok(())
        };
        let in_time = async {
            match deadline {
                None => ready.await,
                Some(deadline) => timeout(deadline, ready).await.unwrap_or_else(|_| {
                    let seconds = deadline.as_secs_f64();
                    Err(CallError::Deadline { service: self.name.clone(), seconds })
                }),
            }
        };
        self.shutdown.unless_requested(in_time).await.unwrap_or(Err(CallError::Shutdown))
    }

    /// Asks until there is an answer, at most until the deadline.
    pub async fn call(
        &self,
        request: S::Request,
        deadline: Option<Duration>,
    ) -> Result<S::Response, CallError> {
        self.answer(self.send(request), deadline).await
    }

    /// Sends a request and returns at once: there may be something to do until the answer comes.
    pub fn send(&self, request: S::Request) -> Call<S> {
        // If it cannot be sent now, it is sent when its answer is waited for.
        let sent = self.try_send(&request).ok();
        Call { request, sent, begun: Instant::now() }
    }

    /// Waits for the answer to a request, and asks again if it does not come.
    pub async fn answer(
        &self,
        call: Call<S>,
        deadline: Option<Duration>,
    ) -> Result<S::Response, CallError> {
        let begun = call.begun;
        let answer = self.answer_until(call, deadline);
        let answer = self.shutdown.unless_requested(answer).await;
        if let Some(Ok(_)) = &answer {
            self.latencies.record(begun.elapsed());
        }
        answer.unwrap_or(Err(CallError::Shutdown))
    }

    async fn answer_until(
        &self,
        call: Call<S>,
        deadline: Option<Duration>,
    ) -> Result<S::Response, CallError> {
        let Call { request, mut sent, begun: _ } = call;
        let start = Instant::now();
        let usual = self.latencies.timeout().unwrap_or(FIRST_WAIT);
        let mut wait = usual.clamp(SHORTEST_WAIT, LONGEST_WAIT);
        loop {
            let mut unsendable = None;
            let attempt = self.attempt(&request, sent.take());
            let end = match deadline {
                Some(deadline) => (Instant::now() + wait).min(start + deadline),
                None => Instant::now() + wait,
            };
            match timeout_at(end, attempt).await {
                // It may pass, as a full send window does.
                Ok(Err(error @ CallError::Unsendable { .. })) => {
                    warn!("{error}; it is tried again");
                    sleep_until(end).await;
                    unsendable = Some(error);
                }
                Ok(result) => return result,
                Err(_) => {}
            }
            if let Some(deadline) = deadline.filter(|deadline| start.elapsed() >= *deadline) {
                let seconds = deadline.as_secs_f64();
                let silent = || CallError::Deadline { service: self.name.clone(), seconds };
                return Err(unsendable.unwrap_or_else(silent));
            }
            let waited = start.elapsed().as_secs_f64();
            // The first repetitions are everyday life where messages are lost, or while the two sides
            // find each other.
            if wait < LONGEST_WAIT {
                debug!("no answer from {} for {waited:.1} s: asking again", self.name);
            } else {
                warn!("no answer from {} for {waited:.1} s: asking again", self.name);
            }
            wait = (wait * 2).min(LONGEST_WAIT);
        }
    }

    async fn attempt(
        &self,
        request: &S::Request,
        sent: Option<Sent<S>>,
    ) -> Result<S::Response, CallError> {
        let Sent { client, id } = match sent {
            Some(sent) => sent,
            None => self.try_send(request)?,
        };
        loop {
            match client.async_receive_response(id).await {
                Ok(response) => return Ok(response),
                // Anybody may have sent it; the answer may still come.
                Err(error) => warn!("an answer of {} cannot be read: {error}", self.name),
            }
        }
    }

    /// Sends a request, by another client if this one's send window is full.
    ///
    /// RustDDS keeps what a matched reader has not acknowledged, at most 8,192 samples, and counts a
    /// server that was killed as one until its lease ends, after some 50 s. The window of a new
    /// client is empty.
    fn try_send(&self, request: &S::Request) -> Result<Sent<S>, CallError> {
        let unsendable =
            |reason: String| CallError::Unsendable { service: self.name.clone(), reason };
        let send = |client: Arc<Client<S::Request, S::Response>>| {
            client.send_request(request.clone()).map(|id| Sent { client: client.clone(), id })
        };
        let mut client = self.client.lock();
        match send(client.clone()) {
            Err(WriteError::WouldBlock { .. }) => {
                debug!("{}: a server has stopped reading; asking by a new client", self.name);
                let fresh = create_client::<S>(&self.node, &self.name).map_err(unsendable)?;
                *client = Arc::new(fresh);
                send(client.clone()).map_err(|error| unsendable(error.to_string()))
            }
            result => result.map_err(|error| unsendable(error.to_string())),
        }
    }
}

/// A client for the service with this absolute name.
pub(crate) fn create_client<S: RosService>(
    node: &SharedNode,
    name: &str,
) -> Result<Client<S::Request, S::Response>, String> {
    let dds_name = Name::parse(name).map_err(|error| error.to_string())?;
    node.lock()
        .create_client(node.mapping, &dds_name, &S::type_name(), services(), services())
        .map_err(|error| error.to_string())
}

/// A request on its way, and who hears the answer.
struct Sent<S: RosService> {
    client: Arc<Client<S::Request, S::Response>>,
    id: RmwRequestId,
}

/// A request whose answer has not been waited for yet.
pub struct Call<S: RosService> {
    request: S::Request,
    sent: Option<Sent<S>>,
    begun: Instant,
}
