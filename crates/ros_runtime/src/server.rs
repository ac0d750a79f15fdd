//! A service server that goes on although a client has died.
//!
//! RustDDS keeps every answer until all clients have acknowledged it, at most 8,192 of them, and counts
//! a client whose process was killed until its lease ends, after some 50 s. A server that answers
//! thousands of requests a second would be silent for the rest of that time. The window of a new one is
//! empty; clients find it as they found the old one, and whoever has no answer asks again.

use std::{sync::Arc, time::Duration};

use log::warn;
use parking_lot::{Mutex, MutexGuard};
use ros_interfaces::RosService;
pub use ros2_client::RmwRequestId as RequestId;
use ros2_client::{Name, Server, error::WriteError};
use tokio::time::timeout;

use crate::{qos::services, shared_node::SharedNode};

/// How long an answer may wait for room in the send window.
const SEND_TIMEOUT: Duration = Duration::from_millis(100);

/// The server of a service.
pub struct ServiceServer<S: RosService> {
    name: String,
    /// Made anew where the send window is full.
    server: Mutex<Arc<Server<S::Request, S::Response>>>,
    node: SharedNode,
}

impl<S: RosService> ServiceServer<S> {
    /// A server of the service with this absolute name.
    pub(crate) fn new(name: String, node: SharedNode) -> Result<ServiceServer<S>, String> {
        let server = Mutex::new(Arc::new(create::<S>(&node, &name)?));
        Ok(ServiceServer { name, server, node })
    }

    /// The absolute name of the service.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Waits for the next request: who is to be answered, and what is asked. What cannot be read is
    /// told of by a warning.
    ///
    /// To stop waiting loses nothing. [`ServiceServer::answer`] may change where requests come to: wait
    /// anew after it.
    pub async fn next_request(&self) -> (RequestId, S::Request) {
        loop {
            match self.server().async_receive_request().await {
                Ok(request) => return request,
                Err(error) => warn!("a request of {} cannot be read: {error}", self.name),
            }
        }
    }

    /// Answers a request, or gives the answer up: the client asks again.
    pub async fn answer(&self, id: RequestId, response: S::Response) {
        match timeout(SEND_TIMEOUT, self.server().async_send_response(id, response)).await {
            Ok(Ok(())) => {}
            // The writer gives up after the same time, or a little sooner.
            Ok(Err(WriteError::WouldBlock { .. })) | Err(_) => {
                warn!("{}: a client has stopped reading its answers; serving anew", self.name);
                match create::<S>(&self.node, &self.name) {
                    Ok(fresh) => *self.lock() = Arc::new(fresh),
                    Err(reason) => warn!("{} cannot be served anew: {reason}", self.name),
                }
            }
            Ok(Err(error)) => warn!("an answer of {} could not be sent: {error}", self.name),
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
