//! Publishes the decisions of an agent whose actions are executed by service.

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

/// The header of the image that was seen last in a room; none before the first.
pub(super) type LatestHeader = Arc<Mutex<Option<Header>>>;

/// Publishes the decisions in a room whose moves are made by service: on `action`, marked as already
/// executed, and on `q_values`.
pub struct Announcer {
    actions: Publisher<ActionCommand>,
    q_values: Publisher<QValues>,
    /// The simulator that serves it hears `action`, too, and would only throw away what it hears.
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

    /// Publishes what the agent is about to do about the image that it has seen last.
    pub fn announce(&self, decision: &Decision) {
        let acts = self.actions.has_readers_besides(&self.step);
        if !acts && !self.q_values.has_readers() {
            return;
        }
        let latest = self.latest.lock().clone();
        let Some(header) = latest else { return };
        let action = decision.action.index();
        if acts {
            let header = Header { stamp: header.stamp, ..Header::default() };
            self.actions.publish(ActionCommand { header, action, sent_by_service: true });
        }
        let Decision { values, explored, .. } = *decision;
        self.q_values.publish_with(|| QValues { header, values, action, explored });
    }
}
