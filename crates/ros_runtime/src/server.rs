//! A service server that keeps responding after a client has been killed.
//!
//! RustDDS keeps up to 8,192 responses until all clients have acknowledged them. It waits for a
//! killed client until the client's lease expires, after about 50 s. If the server handles thousands
//! of requests a second, its send window fills up before that, and it cannot send any more
//! responses. The server is then recreated with an empty window; clients discover it and retry the
//! requests that received no response.

use std::{sync::Arc, time::Duration};

use log::warn;
use parking_lot::{Mutex, MutexGuard};
use ros_interfaces::RosService;
pub use ros2_client::RmwRequestId as RequestId;
use ros2_client::{Name, Server, error::WriteError};
use tokio::time::timeout;

use crate::{qos::services, shared_node::SharedNode};

/// The maximum time for which a response waits for space in the send window.
const SEND_TIMEOUT: Duration = Duration::from_millis(100);

/// A server for a service, created by [`Node::create_server`](crate::Node::create_server).
///
/// # Examples
///
/// ```no_run
/// use ros_interfaces::rcl_interfaces::{ListParameters, list_parameters::Response};
/// use ros_runtime::{Arguments, Node};
///
/// let mut node = Node::new("registry", &Arguments::from_environment()?, &[])?;
/// let server = node.create_server::<ListParameters>("list")?;
/// let shutdown = node.shutdown();
/// node.block_on(async {
///     while let Some((id, request)) = shutdown.unless_requested(server.next_request()).await {
///         let mut response = Response::default();
///         response.result.prefixes = request.prefixes;
///         server.answer(id, response).await;
///     }
/// });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ServiceServer<S: RosService> {
    name: String,
    /// Recreated when its send window is full.
    server: Mutex<Arc<Server<S::Request, S::Response>>>,
    node: SharedNode,
}

impl<S: RosService> ServiceServer<S> {
    /// Creates a server for the service with the absolute name `name`.
    pub(crate) fn new(name: String, node: SharedNode) -> Result<ServiceServer<S>, String> {
        let server = Mutex::new(Arc::new(create::<S>(&node, &name)?));
        Ok(ServiceServer { name, server, node })
    }

    /// Returns the absolute name of the service.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Waits for the next request and returns it with its ID, which [`ServiceServer::answer`]
    /// needs. If a request cannot be deserialized, a warning is logged and the request is skipped.
    ///
    /// This method is cancel-safe: no request is lost. [`ServiceServer::answer`] may recreate the
    /// server, so call this method again afterwards instead of polling an older future.
    pub async fn next_request(&self) -> (RequestId, S::Request) {
        loop {
            match self.server().async_receive_request().await {
                Ok(request) => return request,
                Err(error) => warn!("{}: could not read a request: {error}", self.name),
            }
        }
    }

    /// Sends the response to a request. If it cannot be sent within 100 ms, a warning is logged and
    /// the response is dropped; the client then retries.
    ///
    /// # Panics
    ///
    /// Panics outside a Tokio runtime with timers, such as that of
    /// [`Node::block_on`](crate::Node::block_on).
    pub async fn answer(&self, id: RequestId, response: S::Response) {
        match timeout(SEND_TIMEOUT, self.server().async_send_response(id, response)).await {
            Ok(Ok(())) => {}
            // The writer has its own timeout, which is about as long.
            Ok(Err(WriteError::WouldBlock { .. })) | Err(_) => {
                warn!("{}: responses are not acknowledged; recreating the server", self.name);
                match create::<S>(&self.node, &self.name) {
                    Ok(fresh) => *self.lock() = Arc::new(fresh),
                    Err(reason) => warn!("{}: could not recreate the server: {reason}", self.name),
                }
            }
            Ok(Err(error)) => warn!("{}: could not send a response: {error}", self.name),
        }
    }

    fn server(&self) -> Arc<Server<S::Request, S::Response>> {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Arc<Server<S::Request, S::Response>>> {
        self.server.lock()
    }
}

fn create<S: RosService>(
    node: &SharedNode,
    name: &str,
) -> Result<Server<S::Request, S::Response>, String> {
    let dds_name = Name::parse(name).map_err(|error| error.to_string())?;
    node.lock()
        .create_server(node.mapping, &dds_name, &S::type_name(), services(), services())
        .map_err(|error| error.to_string())
}
