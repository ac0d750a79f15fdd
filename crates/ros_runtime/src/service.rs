//! A service client that retries requests.
//!
//! DDS retransmits a lost sample, but not a sample that was written before the reader and the
//! writer had discovered each other, or one that was lost because its process ended. The client
//! therefore resends a request until it receives the response or its timeout expires. This is safe
//! for services that are idempotent or recognize duplicate requests.

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

use crate::{
    escape::escaped, latency::Latencies, qos::services, shared_node::SharedNode, shutdown::Shutdown,
};

/// The wait before the first retry while no latency is known. Each further wait is twice as long as
/// the previous one, up to [`LONGEST_WAIT`].
const FIRST_WAIT: Duration = Duration::from_millis(250);
/// The shortest wait before the first retry: a busy system may delay a response by this much.
const SHORTEST_WAIT: Duration = Duration::from_millis(20);
/// The longest wait before a retry. A response that takes longer is lost, because by then the
/// client is waiting for the response to the retry.
const LONGEST_WAIT: Duration = Duration::from_secs(2);

/// The error returned if a call receives no response.
#[derive(Debug, Error, PartialEq)]
pub enum CallError {
    /// The timeout expired.
    #[error("no response from the service {service} within {seconds:.1} s: is its node running?")]
    Timeout {
        /// The service.
        service: String,
        /// The timeout, in seconds.
        seconds: f64,
    },
    /// The request could not be sent.
    #[error("could not send a request to the service {service}: {}", escaped(.reason))]
    SendFailed {
        /// The service.
        service: String,
        /// The error reported by DDS.
        reason: String,
    },
    /// The node is shutting down.
    #[error("the node is shutting down")]
    Shutdown,
}

/// A client for a service, created by [`Node::create_client`](crate::Node::create_client).
///
/// # Examples
///
/// ```no_run
/// use std::time::Duration;
///
/// use ros_interfaces::rcl_interfaces::{ListParameters, list_parameters::Request};
/// use ros_runtime::{Arguments, Node};
///
/// let mut node = Node::new("inspector", &Arguments::from_environment()?, &[])?;
/// let client = node.create_client::<ListParameters>("camera/list_parameters")?;
/// let timeout = Some(Duration::from_secs(5));
/// let response = node.block_on(async {
///     client.wait_until_ready(timeout).await?;
///     client.call(Request::default(), timeout).await
/// })?;
/// println!("{:?}", response.result.names);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ServiceClient<S: RosService> {
    pub(crate) name: String,
    /// The DDS topic for requests.
    pub(crate) request_topic: String,
    /// Recreated when its send window is full.
    pub(crate) client: Mutex<Arc<Client<S::Request, S::Response>>>,
    pub(crate) node: SharedNode,
    pub(crate) servers: watch::Receiver<usize>,
    pub(crate) latencies: Latencies,
    pub(crate) shutdown: Shutdown,
}

impl<S: RosService> ServiceClient<S> {
    /// Returns the absolute name of the service.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the number of servers. A killed server counts until its lease expires.
    pub fn servers(&self) -> usize {
        *self.servers.borrow()
    }

    /// Returns the response times.
    pub fn latencies(&self) -> &Latencies {
        &self.latencies
    }

    /// Waits until a server is available, for up to `deadline`; `None` means no timeout.
    ///
    /// # Errors
    ///
    /// Returns an error if the timeout expires or if the node shuts down.
    ///
    /// # Panics
    ///
    /// Same as [`ServiceClient::call`].
    pub async fn wait_until_ready(&self, deadline: Option<Duration>) -> Result<(), CallError> {
        let mut servers = self.servers.clone();
        let ready = async {
            if self.servers() == 0 {
                info!("waiting for the service {}", self.name);
            }
            // Waiting fails only after the node's graph has been dropped.
            let _ = servers.wait_for(|servers| *servers > 0).await;
            Ok(())
        };
        let in_time = async {
            match deadline {
                None => ready.await,
                Some(deadline) => timeout(deadline, ready).await.unwrap_or_else(|_| {
                    let seconds = deadline.as_secs_f64();
                    Err(CallError::Timeout { service: self.name.clone(), seconds })
                }),
            }
        };
        self.shutdown.unless_requested(in_time).await.unwrap_or(Err(CallError::Shutdown))
    }

    /// Sends a request and waits for the response, for up to `deadline`; `None` means no timeout.
    ///
    /// The request is resent if its response is late, so the server may receive duplicates. The
    /// wait before the first retry is four times the median latency, but at least 20 ms and at most
    /// 2 s, or 250 ms if no response has been received yet. Each further wait is twice as long as
    /// the previous one, up to 2 s.
    ///
    /// # Errors
    ///
    /// Returns an error if the timeout expires, if the request cannot be sent by then, or if the
    /// node shuts down.
    ///
    /// # Panics
    ///
    /// Panics outside a Tokio runtime with timers, such as that of
    /// [`Node::block_on`](crate::Node::block_on), or if `deadline` is too long to be added to an
    /// [`Instant`](std::time::Instant).
    pub async fn call(
        &self,
        request: S::Request,
        deadline: Option<Duration>,
    ) -> Result<S::Response, CallError> {
        self.answer(self.send(request), deadline).await
    }

    /// Sends a request without waiting for the response, so that the caller can do other work.
    /// [`answer`](ServiceClient::answer) waits for the response.
    pub fn send(&self, request: S::Request) -> Call<S> {
        // If the request cannot be sent now, `answer` sends it.
        let sent = self.try_send(&request).ok();
        Call { request, sent, start: Instant::now() }
    }

    /// Waits for the response to a request, for up to `deadline` from now, and retries the request
    /// as [`call`](ServiceClient::call) does.
    ///
    /// # Errors
    ///
    /// Same as [`ServiceClient::call`].
    ///
    /// # Panics
    ///
    /// Same as [`ServiceClient::call`].
    pub async fn answer(
        &self,
        call: Call<S>,
        deadline: Option<Duration>,
    ) -> Result<S::Response, CallError> {
        let start = call.start;
        let result = self.response_within(call, deadline);
        let result = self.shutdown.unless_requested(result).await;
        if let Some(Ok(_)) = &result {
            self.latencies.record(start.elapsed());
        }
        result.unwrap_or(Err(CallError::Shutdown))
    }

    async fn response_within(
        &self,
        call: Call<S>,
        deadline: Option<Duration>,
    ) -> Result<S::Response, CallError> {
        let Call { request, mut sent, start: _ } = call;
        let start = Instant::now();
        let first_wait = self.latencies.timeout().unwrap_or(FIRST_WAIT);
        let mut wait = first_wait.clamp(SHORTEST_WAIT, LONGEST_WAIT);
        loop {
            let mut unsendable = None;
            let attempt = self.attempt(&request, sent.take());
            let end = match deadline {
                Some(deadline) => (Instant::now() + wait).min(start + deadline),
                None => Instant::now() + wait,
            };
            match timeout_at(end, attempt).await {
                // The cause may be temporary, such as a full send window.
                Ok(Err(error @ CallError::SendFailed { .. })) => {
                    warn!("{error}; retrying");
                    sleep_until(end).await;
                    unsendable = Some(error);
                }
                Ok(result) => return result,
                Err(_) => {}
            }
            if let Some(deadline) = deadline.filter(|deadline| start.elapsed() >= *deadline) {
                let seconds = deadline.as_secs_f64();
                let expired = || CallError::Timeout { service: self.name.clone(), seconds };
                return Err(unsendable.unwrap_or_else(expired));
            }
            let waited = start.elapsed().as_secs_f64();
            // The first retries are normal on lossy networks and during discovery.
            if wait < LONGEST_WAIT {
                debug!("no response from {} for {waited:.1} s: retrying", self.name);
            } else {
                warn!("no response from {} for {waited:.1} s: retrying", self.name);
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
                // Another participant may have sent this sample, so keep waiting for the response.
                Err(error) => warn!("{}: could not read a response: {error}", self.name),
            }
        }
    }

    /// Sends a request, with a new client if the send window is full.
    ///
    /// RustDDS keeps up to 8,192 samples until all matched readers have acknowledged them. It waits
    /// for a killed server until the server's lease expires, after about 50 s. The window of a new
    /// client is empty.
    fn try_send(&self, request: &S::Request) -> Result<Sent<S>, CallError> {
        let unsendable =
            |reason: String| CallError::SendFailed { service: self.name.clone(), reason };
        let send = |client: Arc<Client<S::Request, S::Response>>| {
            client.send_request(request.clone()).map(|id| Sent { client: client.clone(), id })
        };
        let mut client = self.client.lock();
        match send(client.clone()) {
            Err(WriteError::WouldBlock { .. }) => {
                debug!("{}: requests are not acknowledged; recreating the client", self.name);
                let new = create_client::<S>(&self.node, &self.name).map_err(unsendable)?;
                *client = Arc::new(new);
                send(client.clone()).map_err(|error| unsendable(error.to_string()))
            }
            result => result.map_err(|error| unsendable(error.to_string())),
        }
    }
}

/// Creates a ros2-client client for the service with the absolute name `name`.
pub(crate) fn create_client<S: RosService>(
    node: &SharedNode,
    name: &str,
) -> Result<Client<S::Request, S::Response>, String> {
    let dds_name = Name::parse(name).map_err(|error| error.to_string())?;
    node.lock()
        .create_client(node.mapping, &dds_name, &S::type_name(), services(), services())
        .map_err(|error| error.to_string())
}

/// A request that was sent, and the client that receives its response.
struct Sent<S: RosService> {
    client: Arc<Client<S::Request, S::Response>>,
    id: RmwRequestId,
}

/// A request sent by [`ServiceClient::send`], to be passed to [`ServiceClient::answer`].
pub struct Call<S: RosService> {
    request: S::Request,
    /// `None` if the request could not be sent yet.
    sent: Option<Sent<S>>,
    start: Instant,
}
