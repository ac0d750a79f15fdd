//! The room over DDS: the services `reset` and `step` of a simulator, as an [`Environment`].
//!
//! Messages are lost and simulators are restarted; training must not notice. A lost answer is asked
//! for again, which the simulator recognises by its numbers; what else must be asked, and of a
//! restarted simulator, [`Conversation`] knows.

use std::{num::NonZeroU64, sync::Arc, time::Duration};

use evac_msgs::{Reset, Step as StepService};
use log::warn;
use rand::RngExt;
use ros_interfaces::{RosService, builtin_interfaces::Time};
use ros_runtime::{
    Node,
    node::NodeError,
    service::{Call, ServiceClient},
};
use task::{Action, Environment, Image, Step};

use super::{
    announcer::{Announcer, LatestHeader},
    conversation::{AfterStep, Conversation},
    name_in,
    simulator_error::SimulatorError,
};

/// The simulator as its clients see it.
pub struct Simulator<'a> {
    node: &'a Node,
    connection: Connection,
    deadline: Option<Duration>,
    conversation: Conversation,
}

/// The clients of a simulator's services.
pub struct Connection {
    reset: ServiceClient<Reset>,
    step: Arc<ServiceClient<StepService>>,
    latest: LatestHeader,
}

impl Connection {
    /// Makes the clients of a simulator in a namespace, which is relative to the node's own, empty for
    /// that one; and what publishes the decisions that are sent to it.
    ///
    /// # Errors
    ///
    /// A client or a publisher cannot be made.
    pub fn new(node: &mut Node, namespace: &str) -> Result<(Connection, Announcer), NodeError> {
        let step = Arc::new(node.create_client::<StepService>(&name_in(namespace, "step"))?);
        let latencies = step.latencies().clone();
        node.diagnostics().add(&format!("service {}", step.name()), move || latencies.report());
        let reset = node.create_client::<Reset>(&name_in(namespace, "reset"))?;
        let latest = LatestHeader::default();
        let announcer = Announcer::new(node, namespace, step.clone(), latest.clone())?;
        Ok((Connection { reset, step, latest }, announcer))
    }
}

impl<'a> Simulator<'a> {
    /// Waits until the simulator is there; it must answer each call within the deadline, if there
    /// is one.
    ///
    /// # Errors
    ///
    /// There is no simulator within the deadline, or the node shuts down.
    pub fn connect(
        node: &'a Node,
        connection: Connection,
        deadline: Option<Duration>,
    ) -> Result<Simulator<'a>, SimulatorError> {
        node.block_on(connection.reset.wait_until_ready(deadline))?;
        node.block_on(connection.step.wait_until_ready(deadline))?;
        let simulators = connection.reset.servers();
        if simulators > 1 {
            let service = connection.reset.name();
            warn!(
                "{simulators} nodes serve {service}: two trainings need a ROS_DOMAIN_ID or a namespace \
                 each"
            );
        }
        let conversation = Conversation::new(rand::rng().random());
        Ok(Simulator { node, connection, deadline, conversation })
    }

    /// The node that speaks with the simulator.
    pub fn node(&self) -> &'a Node {
        self.node
    }

    /// The stamp of what was seen last; 0 before the first image.
    pub fn stamp(&self) -> Time {
        self.conversation.header().map_or_else(Time::default, |header| header.stamp)
    }

    /// Lets the announcer know which image was seen last.
    fn note_header(&self) {
        let mut latest = self.connection.latest.lock();
        match (self.conversation.header(), &mut *latest) {
            // Without an allocation at each step.
            (Some(header), Some(latest)) => latest.clone_from(header),
            (header, latest) => *latest = header.cloned(),
        }
    }

    fn answer<S: RosService>(
        &self,
        client: &ServiceClient<S>,
        call: Call<S>,
    ) -> Result<S::Response, SimulatorError> {
        Ok(self.node.block_on(client.answer(call, self.deadline))?)
    }
}

impl Environment for Simulator<'_> {
    type Error = SimulatorError;
    type PendingReset = Call<Reset>;
    type PendingStep = Call<StepService>;

    fn begin_reset(
        &mut self,
        seed: NonZeroU64,
        scenario: &str,
    ) -> Result<Call<Reset>, SimulatorError> {
        let request = self.conversation.begin_episode(seed, scenario);
        Ok(self.connection.reset.send(request))
    }

    fn finish_reset(&mut self, pending: Call<Reset>) -> Result<Image, SimulatorError> {
        let answer = self.answer(&self.connection.reset, pending)?;
        let image = self.conversation.begun(answer)?;
        self.note_header();
        Ok(image)
    }

    fn begin_step(&mut self, action: Action) -> Result<Call<StepService>, SimulatorError> {
        let request = self.conversation.begin_step(action)?;
        Ok(self.connection.step.send(request))
    }

    /// Returns the completed step, after repeating the episode if the simulator was restarted.
    fn finish_step(&mut self, pending: Call<StepService>) -> Result<Step, SimulatorError> {
        let mut pending = pending;
        loop {
            let answer = self.answer(&self.connection.step, pending)?;
            let request = match self.conversation.stepped(answer)? {
                AfterStep::Done(step) => {
                    self.note_header();
                    return Ok(step);
                }
                AfterStep::Step(request) => request,
                AfterStep::Reset(request) => {
                    let call = self.connection.reset.send(request);
                    let answer = self.answer(&self.connection.reset, call)?;
                    self.conversation.repeated(answer)?
                }
            };
            pending = self.connection.step.send(request);
        }
    }
}
