//! The node's loop: requests and commands in, answers and images out.

use std::{pin::pin, sync::Arc, time::Duration};

use anyhow::Context;
use evac_msgs::{ActionCommand, EpisodeStatus, Reset, Step, reset, step};
use futures::{FutureExt, StreamExt, select};
use log::{debug, info, warn};
use ros_runtime::{
    Arguments, Node,
    node::reliable,
    parameters::{ParameterValue, Parameters},
    server::RequestId,
};
use task::Scenario;
use tokio::time::{Instant, Interval, MissedTickBehavior, interval};

use super::{
    diagnostics::Counters,
    messages::nanoseconds,
    parameters::{DeploymentParameters, SimulatorParameters, layout},
    publishers::{Pace, Publishers, until},
    session::{ClientId, Session},
};
use crate::world::World;

/// Runs the simulator until it is told to end.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut node = Node::new("sim_node", arguments, evac_msgs::DEFINITIONS)?;
    let parameters = node.parameters().clone();
    let SimulatorParameters { room, step_duration, deployment } =
        SimulatorParameters::declare(&parameters)?;
    let world = World::new(room.world, room.scenario, room.seed)
        .context("the room cannot be laid out as its parameters say")?;
    let mount = *room.camera.settings();
    let (session, first) = Session::new(world, room.camera, step_duration);
    let publishers = Publishers::new(&mut node)?;
    let resets = node.create_server::<Reset>("reset")?;
    let steps = node.create_server::<Step>("step")?;
    let commands = node.create_subscription::<ActionCommand>("action", reliable(1))?;
    node.start_services()?;
    info!(
        "the room is open: scenario {}, episode {}",
        session.scenario(),
        session.episode_number()
    );
    publishers.publish_mount(&mount, &session);
    node.tell_ready();
    let counters = Counters::reported_by(node.diagnostics());
    let mut room = Room::new(session, &publishers, &parameters, &deployment, counters);
    room.publish(first);

    let shutdown = node.shutdown().clone();
    node.block_on(shutdown.unless_requested(async {
        let mut command_stream = pin!(commands.async_stream());
        let mut arrivals = pin!(publishers.arrivals().fuse());
        let mut frames = deployment.frames();
        loop {
            let mut step_request = pin!(steps.next_request().fuse());
            let mut reset_request = pin!(resets.next_request().fuse());
            let mut step_ends = pin!(until(room.step_end()).fuse());
            let mut motion_ends = pin!(until(room.motion_end()).fuse());
            let mut drawing_due = pin!(until(room.pace.due()).fuse());
            let mut frame_due = pin!(next(&mut frames).fuse());
            select! {
                (id, request) = step_request => {
                    if let Some((response, executed)) = room.step(id, request) {
                        steps.answer(id, response).await;
                        room.publish_if_any(executed);
                    }
                },
                () = step_ends => if let Some((id, response, executed)) = room.finish_step() {
                    steps.answer(id, response).await;
                    room.publish_if_any(executed);
                },
                (id, request) = reset_request => {
                    let client = id.writer_gid.to_bytes16();
                    let (response, executed) = room.reset(client, &request)?;
                    resets.answer(id, response).await;
                    room.publish_if_any(executed);
                },
                command = command_stream.select_next_some() => match command {
                    Ok((command, _)) => room.command(&command)?,
                    Err(error) => warn!("an action cannot be read: {error}"),
                },
                () = motion_ends => room.finish_motion()?,
                () = frame_due => room.publish_frame(),
                () = arrivals.select_next_some() => room.draw(),
                () = drawing_due => room.draw(),
            }
        }
    }))
    .unwrap_or(Ok(()))
}

/// The answer to a request of `/step`, and what is to be published.
type Answer = (step::Response, Option<EpisodeStatus>);

/// A step by `/step` that takes its time.
struct PendingStep {
    end: Instant,
    id: RequestId,
    request: step::Request,
}

/// The room at work: what is asked of the session, and what is published of it.
struct Room<'a> {
    session: Session,
    publishers: &'a Publishers,
    parameters: &'a Parameters,
    deployment: &'a DeploymentParameters,
    counters: Arc<Counters>,
    /// When the clock on the wall began, and at what.
    started: Instant,
    start: Duration,
    /// The step by `/step` that the robot is taking.
    pending: Option<PendingStep>,
    pace: Pace,
    /// Episodes that `/action` has brought to an end, and those of them that were escapes.
    driven: u32,
    escaped: u32,
}

impl<'a> Room<'a> {
    fn new(
        mut session: Session,
        publishers: &'a Publishers,
        parameters: &'a Parameters,
        deployment: &'a DeploymentParameters,
        counters: Arc<Counters>,
    ) -> Room<'a> {
        session.set_motion_time((deployment.motion_time * 1e9).round() as u64);
        let start = nanoseconds(session.now());
        Room {
            session,
            publishers,
            parameters,
            deployment,
            counters,
            started: Instant::now(),
            start: Duration::from_nanos(start),
            pending: None,
            pace: Pace::default(),
            driven: 0,
            escaped: 0,
        }
    }

    fn look_at_the_clock(&mut self) {
        if self.deployment.is_in_real_time() {
            self.session.set_wall_time((self.start + self.started.elapsed()).as_nanos() as u64);
        }
    }

    /// The answer to a request of `/step`; none if there will be one at the end of the move.
    fn step(&mut self, id: RequestId, request: step::Request) -> Option<Answer> {
        let motion_time = Duration::from_secs_f64(self.deployment.motion_time);
        if motion_time.is_zero() || !self.session.is_move(&request) {
            return Some(self.execute_step(&request));
        }
        match &mut self.pending {
            None => {
                self.pending = Some(PendingStep { end: Instant::now() + motion_time, id, request });
                None
            }
            // Asked for again: it is the new request that is waited for.
            Some(pending) if pending.request == request => {
                pending.id = id;
                None
            }
            Some(_) => Some((self.session.busy(), None)),
        }
    }

    fn execute_step(&mut self, request: &step::Request) -> Answer {
        self.look_at_the_clock();
        let (response, executed) = self.session.step(request);
        if !response.success {
            Counters::count(&self.counters.refused);
            debug!("step refused: {}", response.message);
        }
        (response, executed)
    }

    /// When the step that the robot is taking ends.
    fn step_end(&self) -> Option<Instant> {
        self.pending.as_ref().map(|pending| pending.end)
    }

    fn finish_step(&mut self) -> Option<(RequestId, step::Response, Option<EpisodeStatus>)> {
        let PendingStep { id, request, .. } = self.pending.take()?;
        let (response, executed) = self.execute_step(&request);
        Some((id, response, executed))
    }

    fn reset(
        &mut self,
        client: ClientId,
        request: &reset::Request,
    ) -> anyhow::Result<(reset::Response, Option<EpisodeStatus>)> {
        self.look_at_the_clock();
        let default = self.read_parameters()?;
        let (response, executed) = self.session.reset(client, request, default);
        if executed.is_some() {
            // Whoever waits for the end of a step asks again, and hears what has become of it.
            self.pending = None;
        }
        if !response.success {
            Counters::count(&self.counters.refused);
            warn!("reset refused: {}", response.message);
        } else if executed.is_some() && !request.scenario.is_empty() {
            // "Keep" is what the next reset without a scenario does.
            let name = ParameterValue::String(request.scenario.clone());
            self.parameters.set("scenario", name)?;
        }
        Ok((response, executed))
    }

    /// What may have changed since the last reset: the layout, and the scenario.
    fn read_parameters(&mut self) -> anyhow::Result<Scenario> {
        self.session.set_layout(layout(self.parameters)?);
        let scenario: Option<String> = self.parameters.get("scenario");
        let scenario = scenario.and_then(|name| name.parse().ok());
        Ok(scenario.unwrap_or(self.session.scenario()))
    }

    fn command(&mut self, command: &ActionCommand) -> anyhow::Result<()> {
        self.look_at_the_clock();
        let result = match self.pending {
            Some(_) if !command.sent_by_service => Err(self.session.busy().message),
            _ => self.session.command(command),
        };
        match result {
            Ok(None) => {}
            Ok(Some(executed)) => self.end_motion(executed)?,
            Err(reason) => {
                Counters::count(&self.counters.refused);
                warn!("action refused: {reason}");
            }
        }
        Ok(())
    }

    /// When the move that `/action` asked for ends.
    fn motion_end(&self) -> Option<Instant> {
        let end = Duration::from_nanos(self.session.motion_end()?);
        Some(self.started + end.saturating_sub(self.start))
    }

    fn finish_motion(&mut self) -> anyhow::Result<()> {
        self.look_at_the_clock();
        match self.session.finish_motion() {
            Some(executed) => self.end_motion(executed),
            None => Ok(()),
        }
    }

    /// A move of `/action` has ended, and perhaps the episode with it.
    fn end_motion(&mut self, executed: EpisodeStatus) -> anyhow::Result<()> {
        let (steps, escaped) = (executed.step, executed.terminated);
        let is_over = escaped || executed.truncated;
        self.publish(executed);
        if is_over {
            self.driven += 1;
            self.escaped += u32::from(escaped);
            let outcome = if escaped { "escaped" } else { "did not escape" };
            let (all, well) = (self.driven, self.escaped);
            info!("the robot {outcome} in {steps} steps: {well} of {all} episodes so far");
            if self.deployment.auto_reset {
                self.look_at_the_clock();
                let scenario = self.read_parameters()?;
                match self.session.next_episode(scenario) {
                    Ok(executed) => self.publish(executed),
                    Err(reason) => warn!("there is no next episode: {reason}"),
                }
            }
        }
        Ok(())
    }

    fn publish_frame(&mut self) {
        self.look_at_the_clock();
        self.session.pass_time();
        Counters::count(&self.counters.images);
        self.publishers.publish_frame(&self.session);
    }

    fn publish_if_any(&mut self, executed: Option<EpisodeStatus>) {
        if let Some(executed) = executed {
            self.publish(executed);
        }
    }

    fn publish(&mut self, executed: EpisodeStatus) {
        Counters::count(&self.counters.images);
        let is_reset = executed.step == 0;
        let counter = if is_reset { &self.counters.episodes } else { &self.counters.steps };
        Counters::count(counter);
        self.publishers.publish(executed, &self.session);
        if self.publishers.has_viewers() {
            self.draw();
        }
    }

    /// Draws, now or when it is due.
    fn draw(&mut self) {
        if self.pace.is_now() {
            self.publishers.draw(&self.session);
        }
    }
}

impl DeploymentParameters {
    /// When images are due that nothing else brings about; `None`: never.
    fn frames(&self) -> Option<Interval> {
        (self.frame_rate > 0.0).then(|| {
            let mut frames = interval(Duration::from_secs_f64(1.0 / self.frame_rate));
            // An image that was missed is of no use later.
            frames.set_missed_tick_behavior(MissedTickBehavior::Skip);
            frames
        })
    }
}

/// Waits until the next image is due, or for ever.
async fn next(frames: &mut Option<Interval>) {
    match frames {
        Some(frames) => drop(frames.tick().await),
        None => std::future::pending().await,
    }
}
