//! An [`Environment`] that uses the services `reset` and `step` of a simulator.
//!
//! Lost messages and restarted simulators must not affect the result of training. The service
//! client retries a request until it gets a response; the simulator recognizes a retry by its
//! request or step number and executes the request only once. [`Conversation`] replays the episode
//! on a restarted simulator.

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

/// A simulator, or a robot that serves `reset` and `step`, as an [`Environment`].
pub struct Simulator<'a> {
    node: &'a Node,
    connection: Connection,
    deadline: Option<Duration>,
    conversation: Conversation,
}

/// The service clients for one simulator.
pub struct Connection {
    reset: ServiceClient<Reset>,
    step: Arc<ServiceClient<StepService>>,
    /// The header of the latest image, shared with the announcer.
    latest: LatestHeader,
}

impl Connection {
    /// Creates the service clients for the simulator in `namespace`, and the announcer that
    /// publishes the agent's decisions for this simulator. `namespace` is relative to the namespace
    /// of this node; an empty `namespace` means the same namespace.
    ///
    /// # Errors
    ///
    /// Returns an error if a client or a publisher cannot be created.
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
    /// Waits until the services of the simulator are available. `deadline` is the maximum duration of
    /// this wait and of each later call; `None` means no limit.
    ///
    /// # Errors
    ///
    /// Returns [`SimulatorError::Unreachable`] after the timeout, and [`SimulatorError::Shutdown`]
    /// if the node shuts down.
    pub fn connect(
        node: &'a Node,
        connection: Connection,
        deadline: Option<Duration>,
    ) -> Result<Simulator<'a>, SimulatorError> {
        node.block_on(connection.reset.wait_until_ready(deadline))?;
        node.block_on(connection.step.wait_until_ready(deadline))?;
        let servers = connection.reset.servers();
        if servers > 1 {
            let service = connection.reset.name();
            warn!(
                "{servers} nodes serve {service}: give each agent-simulator pair its own \
                 ROS_DOMAIN_ID or namespace"
            );
        }
        let conversation = Conversation::new(rand::rng().random());
        Ok(Simulator { node, connection, deadline, conversation })
    }

    /// Returns the node that the service clients belong to.
    pub fn node(&self) -> &'a Node {
        self.node
    }

    /// Returns the stamp of the latest image; 0 before the first image.
    pub fn stamp(&self) -> Time {
        self.conversation.header().map_or_else(Time::default, |header| header.stamp)
    }

    /// Shares the header of the latest image with the announcer.
    fn share_header(&self) {
        let mut latest = self.connection.latest.lock();
        match (self.conversation.header(), &mut *latest) {
            // Reuses the buffer of the frame name instead of allocating at each step.
            (Some(header), Some(latest)) => latest.clone_from(header),
            (header, latest) => *latest = header.cloned(),
        }
    }

    /// Waits for the response to a call.
    fn response<S: RosService>(
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
        let response = self.response(&self.connection.reset, pending)?;
        let image = self.conversation.begun(response)?;
        self.share_header();
        Ok(image)
    }

    fn begin_step(&mut self, action: Action) -> Result<Call<StepService>, SimulatorError> {
        let request = self.conversation.begin_step(action)?;
        Ok(self.connection.step.send(request))
    }

    /// Returns the result of the step. If the simulator was restarted, replays the episode first.
    fn finish_step(&mut self, pending: Call<StepService>) -> Result<Step, SimulatorError> {
        let mut pending = pending;
        loop {
            let response = self.response(&self.connection.step, pending)?;
            let request = match self.conversation.stepped(response)? {
                AfterStep::Done(step) => {
                    self.share_header();
                    return Ok(step);
                }
                AfterStep::Step(request) => request,
                AfterStep::Reset(request) => {
                    let call = self.connection.reset.send(request);
                    let response = self.response(&self.connection.reset, call)?;
                    self.conversation.repeated(response)?
                }
            };
            pending = self.connection.step.send(request);
        }
    }
}
