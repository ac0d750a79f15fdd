//! The node of ros2-client that endpoints are made by.

use std::sync::Arc;

use parking_lot::{Mutex, MutexGuard};
use ros2_client::ServiceMapping;

/// The node that endpoints belong to: they are made by it, and made anew.
#[derive(Clone)]
pub(crate) struct SharedNode {
    node: Arc<Mutex<ros2_client::Node>>,
    /// How services are mapped to DDS.
    pub(crate) mapping: ServiceMapping,
}

impl SharedNode {
    pub(crate) fn new(node: ros2_client::Node, mapping: ServiceMapping) -> SharedNode {
        SharedNode { node: Arc::new(Mutex::new(node)), mapping }
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, ros2_client::Node> {
        self.node.lock()
    }
}
