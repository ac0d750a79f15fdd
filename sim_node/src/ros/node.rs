//! The node's loop: requests and commands in, answers and images out.

use std::{collections::VecDeque, pin::pin, sync::Arc, time::Duration};

use anyhow::Context;
use evac_msgs::{ActionCommand, Reset, Step, reset, step};
use futures::{FutureExt, StreamExt, select};
use log::{debug, info, warn};
use ros_runtime::{
    Arguments, Node,
    node::reliable,
    parameters::{Descriptor, ParameterValue, Parameters},
};
use tokio::time::{Instant, Interval, MissedTickBehavior, interval};

use super::{
    declare_room,
    diagnostics::Counters,
    parameters::{DeploymentParameters, layout},
    publishers::{Pace, Publishers, until},
    session::{ClientId, Executed, Session},
};
use crate::world::{Scenario, World};

/// Runs the simulator until it is told to end.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut node = Node::new("sim_node", arguments)?;
    let parameters = node.parameters().clone();
    let room = declare_room(&parameters)?;
    let step_duration = parameters.declare(
        "step_duration",
        0.5,
        Descriptor::read_only("simulated time of a step or reset, in seconds").range(1e-9..=3600.0),
    )?;
    let deployment = DeploymentParameters::declare(&parameters)?;
    let use_sim_time = Descriptor::read_only("ROS's switch; unused here");
    parameters.declare("use_sim_time", false, use_sim_time)?;
    parameters.refuse_undeclared()?;

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
    let counters = Counters::reported_by(node.diagnostics());
    let mut room = Room::new(session, &publishers, &parameters, &deployment, counters);
    room.publish(first);

    let shutdown = node.shutdown().clone();
    node.block_on(shutdown.unless_requested(async {
        let mut command_stream = pin!(commands.async_stream());
        let mut arrivals = pin!(publishers.arrivals().fuse());
        let mut frames = deployment.frames();
        // Requests of a step that the robot is still busy with.
        let mut moves = VecDeque::new();
        let motion_time = Duration::from_secs_f64(deployment.motion_time);
        loop {
            let mut step_request = pin!(steps.next_request().fuse());
            let mut reset_request = pin!(resets.next_request().fuse());
            let move_end = moves.front().map(|(end, _, _)| *end);
            let mut move_ends = pin!(until(move_end).fuse());
            let mut motion_ends = pin!(until(room.motion_end()).fuse());
            let mut drawing_due = pin!(until(room.pace.due()).fuse());
            let mut frame_due = pin!(next(&mut frames).fuse());
            select! {
                (id, request) = step_request => {
                    if motion_time.is_zero() {
                        let (response, executed) = room.step(&request);
                        steps.answer(id, response).await;
                        room.publish_if_any(executed);
                    } else {
                        moves.push_back((Instant::now() + motion_time, id, request));
                    }
                },
                () = move_ends => if let Some((_, id, request)) = moves.pop_front() {
                    let (response, executed) = room.step(&request);
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
    .and_then(|()| Ok(shutdown.check()?))
}

/// The room at work: what is asked of the session, and what is published of it.
struct Room<'a> {
    session: Session,
    publishers: &'a Publishers,
    parameters: &'a Parameters,
    deployment: &'a DeploymentParameters,
    counters: Arc<Counters>,
    /// Where the clock on the wall says 0.
    started: Instant,
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
        Room {
            session,
            publishers,
            parameters,
            deployment,
            counters,
            started: Instant::now(),
            pace: Pace::default(),
            driven: 0,
            escaped: 0,
        }
    }

    fn look_at_the_clock(&mut self) {
        if self.deployment.is_in_real_time() {
            self.session.set_wall_time(self.started.elapsed().as_nanos() as u64);
        }
    }

    fn step(&mut self, request: &step::Request) -> (step::Response, Option<Executed>) {
        self.look_at_the_clock();
        let (response, executed) = self.session.step(request);
        if !response.success {
            Counters::count(&self.counters.refused);
            debug!("step refused: {}", response.message);
        }
        (response, executed)
    }

    fn reset(
        &mut self,
        client: ClientId,
        request: &reset::Request,
    ) -> anyhow::Result<(reset::Response, Option<Executed>)> {
        self.look_at_the_clock();
        let default = self.read_parameters()?;
        let (response, executed) = self.session.reset(client, request, default);
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
        match self.session.command(command) {
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
        self.session.motion_end().map(|end| self.started + Duration::from_nanos(end))
    }

    fn finish_motion(&mut self) -> anyhow::Result<()> {
        self.look_at_the_clock();
        match self.session.finish_motion() {
            Some(executed) => self.end_motion(executed),
            None => Ok(()),
        }
    }

    /// A move of `/action` has ended, and perhaps the episode with it.
    fn end_motion(&mut self, executed: Executed) -> anyhow::Result<()> {
        let (steps, escaped) = (executed.status.step, executed.status.terminated);
        let is_over = escaped || executed.status.truncated;
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
        let image = self.session.frame();
        Counters::count(&self.counters.images);
        self.publishers.publish_frame(image, &self.session);
    }

    fn publish_if_any(&mut self, executed: Option<Executed>) {
        if let Some(executed) = executed {
            self.publish(executed);
        }
    }

    fn publish(&mut self, executed: Executed) {
        Counters::count(&self.counters.images);
        let is_reset = executed.status.step == 0;
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
