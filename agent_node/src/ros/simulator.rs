//! The room over DDS: the services `reset` and `step` of a simulator, as an [`Environment`].
//!
//! Messages are lost and simulators are restarted; training must not notice. A lost answer is asked
//! for again, which the simulator recognises by the numbers of episode and step. A restarted
//! simulator knows nothing of the episode, but with a seeded reset a room is a function of the seed
//! and the actions so far: repeating both brings it back to the very same state.

use std::{num::NonZeroU64, time::Duration};

use evac_msgs::{
    ActionCommand, Header, QValues, Reset, Step as StepService, Time, reset, status, step,
};
use log::warn;
use rand::Rng;
use ros_runtime::{
    Node, Publisher,
    node::{NodeError, reliable},
    service::{Call, ServiceClient},
};

use super::name_in;
use crate::{
    environment::{Environment, EnvironmentError, Step},
    learning::{action::Action, dyna_q::Decision, image::Image},
};

/// The simulator as its clients see it.
pub struct Simulator<'a> {
    node: &'a Node,
    connection: Connection,
    deadline: Option<Duration>,
    /// The number of the latest reset request. It starts at random, so that this client's numbers
    /// are nobody else's.
    request: u64,
    episode: Option<Episode>,
    /// The reset and the step under way.
    reset: Option<(NonZeroU64, String, Call<Reset>)>,
    step: Option<(Action, Call<StepService>)>,
}

/// The clients and publishers of the room.
pub struct Connection {
    reset: ServiceClient<Reset>,
    step: ServiceClient<StepService>,
    actions: Publisher<ActionCommand>,
    q_values: Publisher<QValues>,
}

/// The episode under way: everything that is needed to repeat it.
struct Episode {
    number: u64,
    seed: NonZeroU64,
    scenario: String,
    actions: Vec<Action>,
    image: Image,
    /// Of the latest image; what the agent publishes about it carries the same.
    header: Header,
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
        let request = u64::from(rand::rng().next_u32()) << 32;
        Ok(Simulator {
            node,
            connection,
            deadline,
            request,
            episode: None,
            reset: None,
            step: None,
        })
    }

    /// The node that speaks with the simulator.
    pub fn node(&self) -> &'a Node {
        self.node
    }

    /// The stamp of what was seen last; 0 before the first image.
    pub fn stamp(&self) -> Time {
        self.episode.as_ref().map_or_else(Time::default, |episode| episode.header.stamp)
    }

    fn send_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Call<Reset> {
        self.request += 1;
        self.connection.reset.send(reset::Request {
            request: self.request,
            seed: seed.get(),
            scenario: scenario.to_owned(),
        })
    }

    fn answer_to_reset(&self, call: Call<Reset>) -> Result<(u64, Header, Image), EnvironmentError> {
        let answer = self.node.block_on(self.connection.reset.answer(call, self.deadline));
        let response = answer.map_err(unreachable)?;
        match response.status {
            status::OK => {
                let image = image(&response.image)?;
                Ok((response.episode, response.image.header, image))
            }
            status::SUPERSEDED => Err(EnvironmentError::TakenOver(response.message)),
            other => Err(refused(other, response.message)),
        }
    }

    fn call_step(
        &self,
        episode: u64,
        step: u32,
        action: Action,
    ) -> Result<step::Response, EnvironmentError> {
        let request = step::Request { episode, step, action: action.index() };
        let answer = self.node.block_on(self.connection.step.call(request, self.deadline));
        answer.map_err(unreachable)
    }

    /// Brings a restarted simulator to where the episode was. Returns false if it was restarted
    /// again meanwhile.
    fn repeat_episode(&mut self, episode: &mut Episode) -> Result<bool, EnvironmentError> {
        let call = self.send_reset(episode.seed, &episode.scenario);
        let (number, header, mut shown) = self.answer_to_reset(call)?;
        let mut latest = header;
        for (index, action) in episode.actions.iter().enumerate() {
            let response = self.call_step(number, index as u32 + 1, *action)?;
            match response.status {
                status::OK => shown = image(&response.image)?,
                status::SIMULATOR_RESTARTED => return Ok(false),
                status::SUPERSEDED => return Err(EnvironmentError::TakenOver(response.message)),
                other => return Err(refused(other, response.message)),
            }
            latest = response.image.header;
        }
        if shown != episode.image {
            let step = episode.actions.len() as u32;
            return Err(EnvironmentError::NotRepeatable { step, seed: episode.seed.get() });
        }
        (episode.number, episode.header) = (number, latest);
        Ok(true)
    }

    fn publish(&self, episode: &Episode, decision: &Decision) {
        let Some(values) = decision.values else {
            return;
        };
        let action = decision.action.index();
        // The simulator has it already, and would only throw it away.
        if self.connection.actions.has_readers_besides(&self.connection.step) {
            self.connection.actions.publish_with(|| ActionCommand {
                header: Header { stamp: episode.header.stamp, ..Header::default() },
                action,
                sent_by_service: true,
            });
        }
        self.connection.q_values.publish_with(|| QValues {
            header: episode.header.clone(),
            values,
            action,
            explored: decision.explored,
        });
    }

    /// Waits for the end of a step, whatever happens to the simulator meanwhile.
    fn finish(
        &mut self,
        episode: &mut Episode,
        action: Action,
        call: Call<StepService>,
    ) -> Result<Step, EnvironmentError> {
        let number = episode.actions.len() as u32 + 1;
        let answer = self.node.block_on(self.connection.step.answer(call, self.deadline));
        let mut response = answer.map_err(unreachable)?;
        while response.status == status::SIMULATOR_RESTARTED {
            warn!("the simulator was restarted: repeating {} steps", number - 1);
            while !self.repeat_episode(episode)? {}
            response = self.call_step(episode.number, number, action)?;
        }
        match response.status {
            status::OK => {}
            status::SUPERSEDED => return Err(EnvironmentError::TakenOver(response.message)),
            other => return Err(refused(other, response.message)),
        }
        episode.actions.push(action);
        episode.image = image(&response.image)?;
        episode.header = response.image.header;
        Ok(Step {
            image: episode.image.clone(),
            reward: response.reward,
            terminated: response.terminated,
            truncated: response.truncated,
            blocked: response.blocked,
        })
    }
}

impl Environment for Simulator<'_> {
    fn begin_reset(&mut self, seed: NonZeroU64, scenario: &str) -> Result<(), EnvironmentError> {
        let call = self.send_reset(seed, scenario);
        self.reset = Some((seed, scenario.to_owned(), call));
        Ok(())
    }

    fn finish_reset(&mut self) -> Result<Image, EnvironmentError> {
        let begun = self.reset.take();
        let (seed, scenario, call) = begun.ok_or(EnvironmentError::NotBegun("reset"))?;
        let (number, header, image) = self.answer_to_reset(call)?;
        let (actions, first) = (Vec::new(), image.clone());
        self.episode = Some(Episode { number, seed, scenario, actions, image: first, header });
        Ok(image)
    }

    fn begin_step(&mut self, decision: &Decision) -> Result<(), EnvironmentError> {
        let Some(episode) = &self.episode else {
            return Err(EnvironmentError::NotBegun("episode"));
        };
        let request = step::Request {
            episode: episode.number,
            step: episode.actions.len() as u32 + 1,
            action: decision.action.index(),
        };
        self.step = Some((decision.action, self.connection.step.send(request)));
        self.publish(episode, decision);
        Ok(())
    }

    fn finish_step(&mut self) -> Result<Step, EnvironmentError> {
        let (Some(mut episode), Some((action, call))) = (self.episode.take(), self.step.take())
        else {
            return Err(EnvironmentError::NotBegun("step"));
        };
        let result = self.finish(&mut episode, action, call);
        self.episode = Some(episode);
        result
    }
}

fn unreachable(error: ros_runtime::service::CallError) -> EnvironmentError {
    match error {
        ros_runtime::service::CallError::Shutdown => EnvironmentError::Shutdown,
        other => EnvironmentError::Unreachable(other),
    }
}

fn refused(code: u8, message: String) -> EnvironmentError {
    EnvironmentError::Refused(format!("{}: {message}", status::name(code)))
}

/// The image of a message, if it is one of the camera that the networks know.
pub fn image(message: &evac_msgs::Image) -> Result<Image, EnvironmentError> {
    let (width, height, encoding) = (message.width, message.height, message.encoding.as_str());
    if (width, height, encoding, message.step) != (20, 7, "rgb8", 60) {
        return Err(EnvironmentError::BadImage(format!(
            "an image of {width} x {height} pixels, encoding '{encoding}', {} bytes a row: expected \
             20 x 7, rgb8, 60",
            message.step
        )));
    }
    Image::try_from(message.data.as_slice())
        .map_err(|error| EnvironmentError::BadImage(error.to_string()))
}
