//! Qualities of service, by what a topic is for.

use ros2_client::qos::{Durability, History, QosProfile, WhenFull};

/// Reliable, volatile, the last `depth` samples. A publisher never waits for a slow reader: if the
/// send window (8,192 samples) is full, the new sample is dropped for all, and said so.
pub fn reliable(depth: usize) -> QosProfile {
    QosProfile::publisher_default()
        .history(History::KeepLast { depth })
        .reliability_reliable(WhenFull::Fail)
}

/// Best effort, volatile, the last `depth` samples: for samples that are soon followed by newer ones. Such
/// a subscription is compatible with reliable publishers.
pub fn best_effort(depth: usize) -> QosProfile {
    QosProfile::subscription_default()
        .history(History::KeepLast { depth })
        .reliability_best_effort()
}

/// Reliable and transient local: a late subscriber gets the last `depth` samples.
///
/// RustDDS keeps and sends more samples than that: for a topic with more than one message use
/// [`Node::create_latched_publisher`](crate::Node::create_latched_publisher).
pub fn latched(depth: usize) -> QosProfile {
    reliable(depth).durability(Durability::TransientLocal)
}

/// rmw's profile for services: reliable, volatile, the last 10.
pub(crate) fn services() -> QosProfile {
    QosProfile::publisher_default().history(History::KeepLast { depth: 10 })
}
