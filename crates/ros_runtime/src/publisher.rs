//! Publishers that serialize a message only if its topic has subscribers.

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

/// A publisher on a topic, created by [`Node::create_publisher`](crate::Node::create_publisher).
///
/// # Examples
///
/// ```no_run
/// use ros_interfaces::sensor_msgs::Image;
/// use ros_runtime::{Arguments, Node, node::reliable};
///
/// let mut node = Node::new("camera", &Arguments::from_environment()?, &[])?;
/// let images = node.create_publisher::<Image>("image", reliable(5))?;
/// // The closure runs only if the topic has subscribers.
/// images.publish_with(|| Image { height: 7, width: 20, ..Image::default() });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Publisher<M: RosMessage> {
    name: String,
    publisher: ros2_client::Publisher<M>,
    subscribers: watch::Receiver<usize>,
    graph: Graph,
    /// The number of messages that were dropped because a subscriber was too slow.
    unsent: AtomicU64,
}

impl<M: RosMessage> Publisher<M> {
    /// Creates a publisher on a topic, given the topic's absolute name.
    pub(crate) fn new(
        node: &SharedNode,
        graph: &Graph,
        name: String,
        topic: &rustdds::Topic,
    ) -> Result<Publisher<M>, NodeError> {
        let publisher = node.lock().create_publisher(topic, None).map_err(endpoint(&name))?;
        let subscribers = graph.matches(publisher.guid());
        let (graph, unsent) = (graph.clone(), AtomicU64::new(0));
        Ok(Publisher { name, publisher, subscribers, graph, unsent })
    }

    /// Returns whether the topic has subscribers.
    pub fn has_subscribers(&self) -> bool {
        *self.subscribers.borrow() > 0
    }

    /// Returns whether the topic has subscribers in participants other than those that serve
    /// `client`'s service.
    pub fn has_subscribers_other_than<S: RosService>(&self, client: &ServiceClient<S>) -> bool {
        let guid = self.publisher.guid();
        self.has_subscribers() && self.graph.matches_besides(guid, &client.request_topic)
    }

    /// Publishes the message that the function returns. Without subscribers, the function is not
    /// called.
    pub fn publish_with(&self, message: impl FnOnce() -> M) {
        if self.has_subscribers() {
            self.publish(message());
        }
    }

    /// Publishes a message, even without subscribers: with the profile
    /// [`latched`](crate::qos::latched), later subscribers receive it.
    ///
    /// If a message cannot be sent, for example because a subscriber is too slow, it is dropped and
    /// a warning is logged.
    pub fn publish(&self, message: M) {
        match self.publisher.publish(message) {
            Ok(()) => {}
            Err(WriteError::WouldBlock { .. }) => {
                let unsent = self.unsent.fetch_add(1, Ordering::Relaxed) + 1;
                // Logged only if the count is a power of two, because thousands of messages may be
                // dropped.
                if unsent.is_power_of_two() {
                    let name = &self.name;
                    warn!("{name}: a subscriber is too slow; messages dropped so far: {unsent}");
                }
            }
            Err(error) => warn!("{}: could not publish: {error}", self.name),
        }
    }
}

/// A latched publisher for a state: every subscriber receives the latest value, even if it joins
/// later. [`Node::create_latched_publisher`](crate::Node::create_latched_publisher) creates it.
///
/// The topic is transient local with a depth of 1, but RustDDS ignores the depth: it keeps the last
/// 8,192 samples while there are no subscribers and the samples of the last six seconds otherwise,
/// and a late subscriber receives all of them, the oldest first. To avoid this, the publisher
/// writes nothing without subscribers, its owner publishes the state whenever a subscriber joins
/// ([`arrivals`](LatchedPublisher::arrivals)), and the writer and its samples are replaced after
/// the last subscriber has left.
///
/// # Examples
///
/// ```no_run
/// use std::pin::pin;
///
/// use futures::StreamExt;
/// use ros_interfaces::std_msgs::Header;
/// use ros_runtime::{Arguments, Node};
///
/// let mut node = Node::new("camera", &Arguments::from_environment()?, &[])?;
/// let state = node.create_latched_publisher::<Header>("state")?;
/// node.block_on(async {
///     let mut arrivals = pin!(state.arrivals());
///     while let Some(Some(())) = node.shutdown().unless_requested(arrivals.next()).await {
///         state.publish_with(|| Header { stamp: node.clock().now(), ..Header::default() });
///     }
/// });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LatchedPublisher<M: RosMessage> {
    publisher: Mutex<Publisher<M>>,
    node: SharedNode,
    topic: rustdds::Topic,
}

impl<M: RosMessage> LatchedPublisher<M> {
    /// Creates a latched publisher on a topic, given the topic's absolute name.
    pub(crate) fn new(
        node: &SharedNode,
        graph: &Graph,
        name: String,
        topic: rustdds::Topic,
    ) -> Result<LatchedPublisher<M>, NodeError> {
        let publisher = Mutex::new(Publisher::new(node, graph, name, &topic)?);
        Ok(LatchedPublisher { publisher, node: node.clone(), topic })
    }

    /// Returns whether the topic has subscribers.
    pub fn has_subscribers(&self) -> bool {
        self.publisher().has_subscribers()
    }

    /// Publishes the message that the function returns. Without subscribers, the function is not
    /// called.
    pub fn publish_with(&self, message: impl FnOnce() -> M) {
        self.publisher().publish_with(message);
    }

    /// Returns a stream that yields an item whenever a subscriber may have joined; the owner then
    /// publishes the state. Use only one stream at a time.
    pub fn arrivals(&self) -> impl Stream<Item = ()> {
        stream::unfold(None, |previous: Option<watch::Receiver<usize>>| async {
            let mut subscribers = match previous {
                None => self.publisher().subscribers.clone(),
                Some(mut subscribers) => {
                    // This fails only after the node's graph has been dropped.
                    subscribers.changed().await.ok()?;
                    if self.has_subscribers() { subscribers } else { self.replace_writer() }
                }
            };
            subscribers.wait_for(|count| *count > 0).await.ok()?;
            Some(((), Some(subscribers)))
        })
    }

    /// Replaces the writer with a new one, which has no samples, and returns a receiver for the
    /// subscriber count of the new writer.
    fn replace_writer(&self) -> watch::Receiver<usize> {
        let mut publisher = self.publisher();
        match Publisher::new(&self.node, &publisher.graph, publisher.name.clone(), &self.topic) {
            Ok(new) => *publisher = new,
            // The old writer remains, so the next subscriber receives its old samples first.
            Err(error) => debug!("{error}"),
        }
        publisher.subscribers.clone()
    }

    fn publisher(&self) -> MutexGuard<'_, Publisher<M>> {
        self.publisher.lock()
    }
}
