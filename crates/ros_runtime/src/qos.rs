//! Qualities of service, by what a topic is for.

use ros2_client::qos::{Durability, History, QosProfile, WhenFull};

/// Reliable, volatile, the last `depth` samples. A publisher never waits for a slow reader: if the
/// send window (8,192 samples) is full, the new sample is dropped for all, and said so.
pub fn reliable(depth: usize) -> QosProfile {
    QosProfile::publisher_default()
        .history(History::KeepLast { depth })
        .reliability_reliable(WhenFull::Fail)
}

/// Best effort, volatile, the last `depth` samples: for what is soon followed by something newer, so
/// that nobody need wait for what was lost. Such a subscription hears reliable publishers, too.
pub fn best_effort(depth: usize) -> QosProfile {
    QosProfile::subscription_default()
        .history(History::KeepLast { depth })
        .reliability_best_effort()
}

/// Reliable and transient local: whoever comes late gets the last `depth` samples.
///
/// For a topic with more than one message see [`Node::create_latched_publisher`](crate::Node::create_latched_publisher), because RustDDS
/// keeps and sends more samples than that.
pub fn latched(depth: usize) -> QosProfile {
    reliable(depth).durability(Durability::TransientLocal)
}

/// rmw's profile for services: reliable, volatile, the last 10.
pub(crate) fn services() -> QosProfile {
    QosProfile::publisher_default().history(History::KeepLast { depth: 10 })
}
