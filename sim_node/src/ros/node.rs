//! The main loop of the node: handles requests and commands, and publishes images and statuses.

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
    delayed_images::DelayedImages,
    diagnostics::Counters,
    messages::nanoseconds,
    parameters::{DeploymentParameters, SimulatorParameters, layout},
    publishers::{Publishers, Throttle, wait_until},
    reality_parameters,
    session::{ClientId, Session},
};
use crate::{Simulation, world::World};

/// Runs the node until it is shut down.
///
/// # Errors
///
/// Returns an error if the arguments or parameters are invalid, or if the node cannot be started.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut node = Node::new("sim_node", arguments, evac_msgs::DEFINITIONS)?;
    let parameters = node.parameters().clone();
    let SimulatorParameters { room, step_duration, deployment } =
        SimulatorParameters::declare(&parameters)?;
    let world = World::new(room.world, room.scenario, room.seed)
        .context("the fixed_* parameters do not allow a valid layout")?;
    let mount = *room.camera.settings();
    let simulation = Simulation::new(world, room.camera);
    let (session, first) = Session::new(simulation, step_duration);
    let publishers = Publishers::new(&mut node)?;
    let resets = node.create_server::<Reset>("reset")?;
    let steps = node.create_server::<Step>("step")?;
    let commands = node.create_subscription::<ActionCommand>("action", reliable(1))?;
    node.start_services()?;
    info!("simulator ready");
    publishers.publish_mount(&mount, &session);
    node.notify_ready();
    let counters = Counters::reported_by(node.diagnostics());
    let mut simulator = Simulator::new(session, &publishers, &parameters, &deployment, counters);
    simulator.publish(first);

    let shutdown = node.shutdown().clone();
    node.block_on(shutdown.unless_requested(async {
        let mut command_stream = pin!(commands.async_stream());
        let mut arrivals = pin!(publishers.arrivals().fuse());
        let mut frames = deployment.frames();
        loop {
            let mut step_request = pin!(steps.next_request().fuse());
            let mut reset_request = pin!(resets.next_request().fuse());
            let mut step_end = pin!(wait_until(simulator.step_end()).fuse());
            let mut motion_end = pin!(wait_until(simulator.motion_end()).fuse());
            let mut visualization_due = pin!(wait_until(simulator.throttle.due()).fuse());
            let mut frame_due = pin!(next(&mut frames).fuse());
            let mut image_due = pin!(wait_until(simulator.delayed.due()).fuse());
            select! {
                (id, request) = step_request => {
                    if let Some((response, executed)) = simulator.step(id, request) {
                        steps.answer(id, response).await;
                        simulator.publish_if_executed(executed);
                    }
                },
                () = step_end => if let Some((id, response, executed)) = simulator.finish_step() {
                    steps.answer(id, response).await;
                    simulator.publish_if_executed(executed);
                },
                (id, request) = reset_request => {
                    let client = id.writer_gid.to_bytes16();
                    let (response, executed) = simulator.reset(client, &request)?;
                    resets.answer(id, response).await;
                    simulator.publish_if_executed(executed);
                },
                command = command_stream.select_next_some() => match command {
                    Ok((command, _)) => simulator.command(&command)?,
                    Err(error) => warn!("cannot deserialize a message on action: {error}"),
                },
                () = motion_end => simulator.finish_motion()?,
                () = frame_due => simulator.publish_frame(),
                () = image_due => simulator.publish_delayed_images(),
                () = arrivals.select_next_some() => simulator.visualize(),
                () = visualization_due => simulator.visualize(),
            }
        }
    }))
    .unwrap_or(Ok(()))
}

/// The response to a `/step` request, and the status to publish if the request was executed.
type StepResult = (step::Response, Option<EpisodeStatus>);

/// A `/step` request whose move is in progress.
struct PendingStep {
    end: Instant,
    id: RequestId,
    request: step::Request,
}

/// Passes requests, commands and the wall-clock time to the session and publishes the results.
struct Simulator<'a> {
    session: Session,
    publishers: &'a Publishers,
    parameters: &'a Parameters,
    deployment: &'a DeploymentParameters,
    counters: Arc<Counters>,
    /// When the node started.
    started: Instant,
    /// Simulated time when the node started. If simulated time follows the wall clock, it is
    /// `start` plus the time since `started`.
    start: Duration,
    /// The `/step` request that is being executed.
    pending: Option<PendingStep>,
    throttle: Throttle,
    delayed: DelayedImages,
    /// Number of finished episodes that were controlled through `/action`.
    episodes: u32,
    /// Number of these episodes in which the robot escaped.
    successes: u32,
}

impl<'a> Simulator<'a> {
    fn new(
        mut session: Session,
        publishers: &'a Publishers,
        parameters: &'a Parameters,
        deployment: &'a DeploymentParameters,
        counters: Arc<Counters>,
    ) -> Simulator<'a> {
        session.set_motion_time((deployment.motion_time * 1e9).round() as u64);
        let start = nanoseconds(session.now());
        Simulator {
            session,
            publishers,
            parameters,
            deployment,
            counters,
            started: Instant::now(),
            start: Duration::from_nanos(start),
            pending: None,
            throttle: Throttle::default(),
            delayed: DelayedImages::default(),
            episodes: 0,
            successes: 0,
        }
    }

    /// Passes the wall-clock time to the session if simulated time follows it.
    fn update_time(&mut self) {
        if self.deployment.is_in_real_time() {
            self.session.set_wall_time((self.start + self.started.elapsed()).as_nanos() as u64);
        }
    }

    /// Handles a `/step` request. Returns `None` if the response follows at the end of the move.
    fn step(&mut self, id: RequestId, request: step::Request) -> Option<StepResult> {
        let motion_time = Duration::from_secs_f64(self.deployment.motion_time);
        if motion_time.is_zero() || !self.session.is_move(&request) {
            return Some(self.execute_step(&request));
        }
        match &mut self.pending {
            None => {
                self.pending = Some(PendingStep { end: Instant::now() + motion_time, id, request });
                None
            }
            // A retry: the client waits for the response to the new request.
            Some(pending) if pending.request == request => {
                pending.id = id;
                None
            }
            Some(_) => {
                Counters::count(&self.counters.refused);
                Some((self.session.busy(), None))
            }
        }
    }

    fn execute_step(&mut self, request: &step::Request) -> StepResult {
        self.update_time();
        let (response, executed) = self.session.step(request);
        if !response.success {
            Counters::count(&self.counters.refused);
            debug!("step refused: {}", response.message);
        }
        (response, executed)
    }

    /// Returns when the `/step` request in progress ends.
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
        self.update_time();
        let default = self.read_parameters()?;
        let (response, executed) = self.session.reset(client, request, default);
        if executed.is_some() {
            // A client that is waiting for a step to end will retry, and its request will be
            // refused.
            self.pending = None;
        }
        if !response.success {
            Counters::count(&self.counters.refused);
            warn!("reset refused: {}", response.message);
        } else if executed.is_some() && !request.scenario.is_empty() {
            // Later resets without a scenario use this one.
            let name = ParameterValue::String(request.scenario.clone());
            self.parameters.set("scenario", name)?;
        }
        Ok((response, executed))
    }

    /// Reads the parameters that take effect at a reset. Sets layout and perturbations, and returns
    /// the scenario.
    fn read_parameters(&mut self) -> anyhow::Result<Scenario> {
        self.session.set_reality(reality_parameters::read(self.parameters)?);
        self.session.set_layout(layout(self.parameters)?);
        let scenario: Option<String> = self.parameters.get("scenario");
        let scenario = scenario.and_then(|name| name.parse().ok());
        Ok(scenario.unwrap_or(self.session.scenario()))
    }

    fn command(&mut self, command: &ActionCommand) -> anyhow::Result<()> {
        self.update_time();
        let result = match self.pending {
            Some(_) if !command.sent_by_service => Err(self.session.busy().message),
            _ => self.session.command(command),
        };
        match result {
            Ok(None) => {}
            Ok(Some(executed)) => self.complete_motion(executed)?,
            Err(reason) => {
                Counters::count(&self.counters.refused);
                warn!("action refused: {reason}");
            }
        }
        Ok(())
    }

    /// Returns when the move commanded through `/action` ends.
    fn motion_end(&self) -> Option<Instant> {
        let end = Duration::from_nanos(self.session.motion_end()?);
        Some(self.started + end.saturating_sub(self.start))
    }

    fn finish_motion(&mut self) -> anyhow::Result<()> {
        self.update_time();
        match self.session.finish_motion() {
            Some(executed) => self.complete_motion(executed),
            None => Ok(()),
        }
    }

    /// Publishes the result of a move commanded through `/action`. If the episode is over, logs its
    /// outcome and starts the next one if `auto_reset` is set.
    fn complete_motion(&mut self, executed: EpisodeStatus) -> anyhow::Result<()> {
        let (steps, escaped) = (executed.step, executed.terminated);
        let is_over = escaped || executed.truncated;
        self.publish(executed);
        if is_over {
            self.episodes += 1;
            self.successes += u32::from(escaped);
            let outcome = if escaped { "escaped" } else { "did not escape" };
            let (episodes, successes) = (self.episodes, self.successes);
            let plural = if steps == 1 { "" } else { "s" };
            info!(
                "the robot {outcome} in {steps} step{plural} (success in {successes} of {episodes} \
                 episodes so far)"
            );
            if self.deployment.auto_reset {
                self.update_time();
                let scenario = self.read_parameters()?;
                match self.session.next_episode(scenario) {
                    Ok(executed) => self.publish(executed),
                    Err(reason) => warn!("cannot start the next episode: {reason}"),
                }
            }
        }
        Ok(())
    }

    fn publish_frame(&mut self) {
        self.update_time();
        self.session.take_image();
        self.publish_image();
    }

    /// Publishes time and pose, and then the image, unless it is lost or delayed. Without real
    /// time, an image is never lost: it is replaced by the one before.
    fn publish_image(&mut self) {
        self.publishers.publish_pose(&self.session);
        let latency = self.session.world().conditions().camera.latency;
        if self.deployment.is_in_real_time() && self.session.is_image_dropped() {
            Counters::count(&self.counters.lost_images);
        } else if self.deployment.is_in_real_time()
            && (latency > 0.0 || self.delayed.due().is_some())
        {
            // Images keep their order if the latency becomes 0.
            let due = Instant::now() + Duration::from_secs_f64(latency);
            self.delayed.push(due, self.session.image());
        } else {
            Counters::count(&self.counters.images);
            self.publishers.publish_image(&self.session);
        }
    }

    fn publish_delayed_images(&mut self) {
        while let Some(image) = self.delayed.pop(Instant::now()) {
            Counters::count(&self.counters.images);
            self.publishers.publish_earlier_image(image);
        }
    }

    fn publish_if_executed(&mut self, executed: Option<EpisodeStatus>) {
        if let Some(executed) = executed {
            self.publish(executed);
        }
    }

    fn publish(&mut self, executed: EpisodeStatus) {
        let is_reset = executed.step == 0;
        if is_reset {
            self.counters.record_perturbations(self.session.world());
        }
        let counter = if is_reset { &self.counters.episodes } else { &self.counters.steps };
        Counters::count(counter);
        self.publish_image();
        self.publishers.publish_status(executed);
        if self.publishers.has_visualization_subscribers() {
            self.visualize();
        }
    }

    /// Publishes the visualization now, or later when the throttle permits it.
    fn visualize(&mut self) {
        if self.throttle.request() {
            self.publishers.publish_visualization(&self.session);
        }
    }
}

impl DeploymentParameters {
    /// Returns the timer for images published in addition to the image after each reset or step;
    /// `None` if `frame_rate` is 0.
    fn frames(&self) -> Option<Interval> {
        (self.frame_rate > 0.0).then(|| {
            let mut frames = interval(Duration::from_secs_f64(1.0 / self.frame_rate));
            // Skips missed images: the next one shows the current state.
            frames.set_missed_tick_behavior(MissedTickBehavior::Skip);
            frames
        })
    }
}

/// Waits until the next image is due, or forever if there is no timer.
async fn next(frames: &mut Option<Interval>) {
    match frames {
        Some(frames) => drop(frames.tick().await),
        None => std::future::pending().await,
    }
}
