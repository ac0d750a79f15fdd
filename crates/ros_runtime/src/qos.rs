//! Quality-of-service profiles for topics and services.
//!
//! # Examples
//!
//! ```no_run
//! use ros_interfaces::{sensor_msgs::Image, std_msgs::Header};
//! use ros_runtime::{
//!     Arguments, Node,
//!     qos::{best_effort, reliable},
//! };
//!
//! let mut node = Node::new("camera", &Arguments::from_environment()?, &[])?;
//! let headers = node.create_publisher::<Header>("header", reliable(10))?;
//! let images = node.create_subscription::<Image>("image", best_effort(1))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use ros2_client::qos::{Durability, History, QosProfile, WhenFull};

/// Returns a reliable, volatile profile that keeps the last `depth` samples.
///
/// A publisher never waits for a slow subscriber: if its send window (8,192 samples) is full, it
/// drops the new sample for all subscribers and logs a warning.
pub fn reliable(depth: usize) -> QosProfile {
    QosProfile::publisher_default()
        .history(History::KeepLast { depth })
        .reliability_reliable(WhenFull::Fail)
}

/// Returns a best-effort, volatile profile that keeps the last `depth` samples.
///
/// Use this profile for samples that newer ones soon replace. A subscription with this profile is
/// compatible with reliable publishers.
pub fn best_effort(depth: usize) -> QosProfile {
    QosProfile::subscription_default()
        .history(History::KeepLast { depth })
        .reliability_best_effort()
}

/// Returns a latched profile, reliable and transient local: a subscriber that joins later receives
/// the last `depth` samples.
///
/// RustDDS keeps and sends more than `depth` samples. For a topic with more than one message, use
/// [`Node::create_latched_publisher`](crate::Node::create_latched_publisher).
pub fn latched(depth: usize) -> QosProfile {
    reliable(depth).durability(Durability::TransientLocal)
}

/// Returns rmw's profile for services: reliable, volatile, keeping the last 10 samples.
pub(crate) fn services() -> QosProfile {
    QosProfile::publisher_default().history(History::KeepLast { depth: 10 })
}
