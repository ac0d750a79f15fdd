//! The ros2-client node that creates endpoints.

use std::sync::Arc;

use parking_lot::{Mutex, MutexGuard};
use ros2_client::ServiceMapping;

/// A ros2-client node that creates and recreates all endpoints. Clones share it.
#[derive(Clone)]
pub(crate) struct SharedNode {
    node: Arc<Mutex<ros2_client::Node>>,
    /// The mapping from services to DDS.
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
