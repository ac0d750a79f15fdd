//! Publishers that serialise a message only if it has subscribers.

use std::sync::atomic::{AtomicU64, Ordering};

use futures::{Stream, stream};
use log::{debug, warn};
use parking_lot::{Mutex, MutexGuard};
use ros_interfaces::{RosMessage, RosService};
use ros2_client::error::WriteError;
use tokio::sync::watch;

use crate::{
    graph::Graph,
    node_error::{NodeError, endpoint},
    service::ServiceClient,
    shared_node::SharedNode,
};

/// A publisher that does nothing without subscribers.
pub struct Publisher<M: RosMessage> {
    name: String,
    publisher: ros2_client::Publisher<M>,
    readers: watch::Receiver<usize>,
    graph: Graph,
    /// The number of messages that were dropped because a subscriber was too slow.
    unsent: AtomicU64,
}

impl<M: RosMessage> Publisher<M> {
    pub(crate) fn new(
        node: &SharedNode,
        graph: &Graph,
        name: String,
        topic: &rustdds::Topic,
    ) -> Result<Publisher<M>, NodeError> {
        let publisher = node.lock().create_publisher(topic, None).map_err(endpoint(&name))?;
        let readers = graph.matches(publisher.guid());
        let (graph, unsent) = (graph.clone(), AtomicU64::new(0));
        Ok(Publisher { name, publisher, readers, graph, unsent })
    }

    /// Whether the topic has subscribers now.
    pub fn has_readers(&self) -> bool {
        *self.readers.borrow() > 0
    }

    /// Whether the topic has subscribers besides the nodes that serve a service.
    pub fn has_readers_besides<S: RosService>(&self, servers: &ServiceClient<S>) -> bool {
        let guid = self.publisher.guid();
        self.has_readers() && self.graph.matches_besides(guid, &servers.request_topic)
    }

    /// Publishes the message that the function returns; it is not called without subscribers.
    pub fn publish_with(&self, message: impl FnOnce() -> M) {
        if self.has_readers() {
            self.publish(message());
        }
    }

    /// Publishes a message also without subscribers: a [`latched`](crate::qos::latched) one is sent to those
    /// that come later.
    pub fn publish(&self, message: M) {
        match self.publisher.publish(message) {
            Ok(()) => {}
            Err(WriteError::WouldBlock { .. }) => {
                let unsent = self.unsent.fetch_add(1, Ordering::Relaxed) + 1;
                // Less and less often: it may last, and there may be thousands a second.
                if unsent.is_power_of_two() {
                    let name = &self.name;
                    warn!("{name}: a reader is too slow; {unsent} messages were not sent so far");
                }
            }
            Err(error) => warn!("{}: could not publish: {error}", self.name),
        }
    }
}

/// A publisher of a state, of which every reader gets the latest, however late it comes.
///
/// The topic is transient local with a depth of 1, but RustDDS ignores that depth: without readers it
/// keeps the last 8,192 samples, otherwise all those of the last six seconds, and a late reader gets
/// every one of them, the oldest first. So nothing is written without readers, the owner publishes the
/// state when a reader arrives ([`LatchedPublisher::arrivals`]), and when the last reader has left, the
/// writer is replaced, and with it what it has kept.
pub struct LatchedPublisher<M: RosMessage> {
    publisher: Mutex<Publisher<M>>,
    node: SharedNode,
    topic: rustdds::Topic,
}

impl<M: RosMessage> LatchedPublisher<M> {
    pub(crate) fn new(
        node: &SharedNode,
        graph: &Graph,
        name: String,
        topic: rustdds::Topic,
    ) -> Result<LatchedPublisher<M>, NodeError> {
        let publisher = Mutex::new(Publisher::new(node, graph, name, &topic)?);
        Ok(LatchedPublisher { publisher, node: node.clone(), topic })
    }

    /// Whether the topic has subscribers now.
    pub fn has_readers(&self) -> bool {
        self.publisher().has_readers()
    }

    /// Publishes the message that the function returns; it is not called without subscribers.
    pub fn publish_with(&self, message: impl FnOnce() -> M) {
        self.publisher().publish_with(message);
    }

    /// Yields an item whenever a new subscriber may lack the state: publish it.
    pub fn arrivals(&self) -> impl Stream<Item = ()> {
        stream::unfold(None, |known: Option<watch::Receiver<usize>>| async {
            let mut readers = match known {
                None => self.publisher().readers.clone(),
                Some(mut readers) => {
                    // The sender lives as long as the node's graph.
                    readers.changed().await.ok()?;
                    if self.has_readers() { readers } else { self.forget() }
                }
            };
            readers.wait_for(|count| *count > 0).await.ok()?;
            Some(((), Some(readers)))
        })
    }

    /// Replaces the writer by one that has sent nothing yet; its readers.
    fn forget(&self) -> watch::Receiver<usize> {
        let mut publisher = self.publisher();
        match Publisher::new(&self.node, &publisher.graph, publisher.name.clone(), &self.topic) {
            Ok(fresh) => *publisher = fresh,
            // The next reader then gets what the old one has kept, and after it the state.
            Err(error) => debug!("{error}"),
        }
        publisher.readers.clone()
    }

    fn publisher(&self) -> MutexGuard<'_, Publisher<M>> {
        self.publisher.lock()
    }
}
