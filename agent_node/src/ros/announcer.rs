//! Publishes the decisions of an agent that acts through the `step` service.

use std::sync::Arc;

use evac_msgs::{ActionCommand, QValues, Step};
use learning::dyna_q::Decision;
use parking_lot::Mutex;
use ros_interfaces::std_msgs::Header;
use ros_runtime::{
    Node, Publisher,
    node::{NodeError, reliable},
    service::ServiceClient,
};

use super::name_in;

/// The header of the latest image from an environment; `None` before the first image.
pub(super) type LatestHeader = Arc<Mutex<Option<Header>>>;

/// Publishes each decision on `action` and its Q-values on `q_values`. The commands have
/// `sent_by_service` set, because the `step` service executes the action.
pub struct Announcer {
    actions: Publisher<ActionCommand>,
    q_values: Publisher<QValues>,
    /// Identifies the simulator, which subscribes to `action` but discards commands with
    /// `sent_by_service` set. Actions are not published if the simulator is the only subscriber.
    step: Arc<ServiceClient<Step>>,
    latest: LatestHeader,
}

impl Announcer {
    pub(super) fn new(
        node: &mut Node,
        namespace: &str,
        step: Arc<ServiceClient<Step>>,
        latest: LatestHeader,
    ) -> Result<Announcer, NodeError> {
        let name = |name: &str| name_in(namespace, name);
        Ok(Announcer {
            actions: node.create_publisher(&name("action"), reliable(1))?,
            q_values: node.create_publisher(&name("q_values"), reliable(10))?,
            step,
            latest,
        })
    }

    /// Publishes the decision for the latest image on each topic that has subscribers.
    pub fn announce(&self, decision: &Decision) {
        let publish_action = self.actions.has_subscribers_other_than(&self.step);
        if !publish_action && !self.q_values.has_subscribers() {
            return;
        }
        let latest = self.latest.lock().clone();
        let Some(header) = latest else { return };
        let action = decision.action.index();
        if publish_action {
            let header = Header { stamp: header.stamp, ..Header::default() };
            self.actions.publish(ActionCommand { header, action, sent_by_service: true });
        }
        let Decision { values, explored, .. } = *decision;
        self.q_values.publish_with(|| QValues { header, values, action, explored });
    }
}
