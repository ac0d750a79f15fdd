//! The room over DDS: the services `reset` and `step` of a simulator, as an [`Environment`].
//!
//! Messages are lost and simulators are restarted; training must not notice. A lost answer is asked
//! for again, which the simulator recognises by its numbers; what else must be asked, and of a
//! restarted simulator, [`Conversation`] knows.

use std::{num::NonZeroU64, time::Duration};

use evac_msgs::{ActionCommand, Header, QValues, Reset, Step as StepService, Time};
use log::warn;
use rand::RngExt;
use ros_runtime::{
    Node, Publisher,
    node::{NodeError, reliable},
    service::{Call, CallError, ServiceClient},
};
use task::Image;

use super::{
    conversation::{Answer, Conversation, Done, Next, Request},
    name_in,
};
use crate::{
    environment::{Environment, EnvironmentError, Step},
    learning::dyna_q::Decision,
};

/// The simulator as its clients see it.
pub struct Simulator<'a> {
    node: &'a Node,
    connection: Connection,
    deadline: Option<Duration>,
    conversation: Conversation,
    /// The reset or the step under way.
    asked: Option<Asked>,
}

/// The clients and publishers of the room.
pub struct Connection {
    reset: ServiceClient<Reset>,
    step: ServiceClient<StepService>,
    actions: Publisher<ActionCommand>,
    q_values: Publisher<QValues>,
}

/// A request that was sent.
enum Asked {
    Reset(Call<Reset>),
    Step(Call<StepService>),
}

impl Connection {
    /// Makes the clients and publishers of a simulator in a namespace, which is relative to the
    /// node's own; empty for that one.
    pub fn new(node: &mut Node, namespace: &str) -> Result<Connection, NodeError> {
        let name = |name: &str| name_in(namespace, name);
        let step = node.create_client::<StepService>(&name("step"))?;
        let latencies = step.latencies().clone();
        node.diagnostics().add(&format!("service {}", step.name()), move || latencies.report());
        Ok(Connection {
            reset: node.create_client::<Reset>(&name("reset"))?,
            step,
            actions: node.create_publisher(&name("action"), reliable(1))?,
            q_values: node.create_publisher(&name("q_values"), reliable(10))?,
        })
    }

    fn send(&self, request: Request) -> Asked {
        match request {
            Request::Reset(request) => Asked::Reset(self.reset.send(request)),
            Request::Step(request) => Asked::Step(self.step.send(request)),
        }
    }

    async fn answer(
        &self,
        asked: Asked,
        deadline: Option<Duration>,
    ) -> Result<Answer, EnvironmentError> {
        let answer = match asked {
            Asked::Reset(call) => self.reset.answer(call, deadline).await.map(Answer::Reset),
            Asked::Step(call) => self.step.answer(call, deadline).await.map(Answer::Step),
        };
        answer.map_err(unreachable)
    }
}

impl<'a> Simulator<'a> {
    /// Waits until the simulator is there; it must answer each call within the deadline, if there
    /// is one.
    pub fn connect(
        node: &'a Node,
        connection: Connection,
        deadline: Option<Duration>,
    ) -> Result<Simulator<'a>, EnvironmentError> {
        node.block_on(connection.reset.wait_until_ready(deadline)).map_err(unreachable)?;
        node.block_on(connection.step.wait_until_ready(deadline)).map_err(unreachable)?;
        let simulators = connection.reset.servers();
        if simulators > 1 {
            let service = connection.reset.name();
            warn!(
                "{simulators} nodes serve {service}: two trainings need a ROS_DOMAIN_ID or a namespace \
                 each"
            );
        }
        let conversation = Conversation::new(rand::rng().random());
        Ok(Simulator { node, connection, deadline, conversation, asked: None })
    }

    /// The node that speaks with the simulator.
    pub fn node(&self) -> &'a Node {
        self.node
    }

    /// The stamp of what was seen last; 0 before the first image.
    pub fn stamp(&self) -> Time {
        self.conversation.header().map_or_else(Time::default, |header| header.stamp)
    }

    fn publish(&self, decision: &Decision) {
        let (Some(values), Some(header)) = (decision.values, self.conversation.header()) else {
            return;
        };
        let action = decision.action.index();
        // The simulator has it already, and would only throw it away.
        if self.connection.actions.has_readers_besides(&self.connection.step) {
            self.connection.actions.publish_with(|| ActionCommand {
                header: Header { stamp: header.stamp, ..Header::default() },
                action,
                sent_by_service: true,
            });
        }
        self.connection.q_values.publish_with(|| QValues {
            header: header.clone(),
            values,
            action,
            explored: decision.explored,
        });
    }

    /// Asks until what was begun is done, whatever happens to the simulator meanwhile.
    fn finish(&mut self, begun: &'static str) -> Result<Done, EnvironmentError> {
        let mut asked = self.asked.take().ok_or(EnvironmentError::NotBegun(begun))?;
        loop {
            let answer = self.node.block_on(self.connection.answer(asked, self.deadline))?;
            match self.conversation.hear(answer)? {
                Next::Ask(request) => asked = self.connection.send(request),
                Next::Done(done) => return Ok(done),
            }
        }
    }
}

impl Environment for Simulator<'_> {
    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<(), EnvironmentError> {
        let request = self.conversation.begin_episode(seed, scenario);
        self.asked = Some(self.connection.send(request));
        Ok(())
    }

    fn finish_reset(&mut self) -> Result<Image, EnvironmentError> {
        match self.finish("reset")? {
            Done::Reset(image) => Ok(image),
            Done::Step(_) => Err(EnvironmentError::NotBegun("reset")),
        }
    }

    fn begin_step(&mut self, decision: &Decision) -> Result<(), EnvironmentError> {
        let request = self.conversation.begin_step(decision.action)?;
        self.asked = Some(self.connection.send(request));
        self.publish(decision);
        Ok(())
    }

    fn finish_step(&mut self) -> Result<Step, EnvironmentError> {
        match self.finish("step")? {
            Done::Step(step) => Ok(step),
            Done::Reset(_) => Err(EnvironmentError::NotBegun("step")),
        }
    }
}

fn unreachable(error: CallError) -> EnvironmentError {
    match error {
        CallError::Shutdown => EnvironmentError::Shutdown,
        other => EnvironmentError::Unreachable(other),
    }
}
