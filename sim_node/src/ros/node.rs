//! The node's loop: requests and commands in, answers and images out.

use std::{future::Future, pin::pin, time::Duration};

use anyhow::Context;
use evac_msgs::{ActionCommand, Reset, Step};
use futures::{FutureExt, StreamExt, select};
use log::{debug, info, warn};
use ros_runtime::{Arguments, Node, node::reliable, parameters::ParameterValue};

use super::{
    declare_room,
    parameters::layout,
    publishers::{Pace, Publishers, until},
    session::{Executed, Session},
};
use crate::world::{Scenario, World};

/// How long an answer may wait for room in the send window.
const SEND_TIMEOUT: Duration = Duration::from_millis(100);

/// Runs the simulator until it is told to end.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut node = Node::new("sim_node", arguments)?;
    let parameters = node.parameters().clone();
    let room = declare_room(&parameters)?;
    let step_duration = parameters.declare(
        "step_duration",
        0.5,
        ros_runtime::parameters::Descriptor::read_only(
            "simulated time of a step or reset, in seconds",
        )
        .range(1e-9..=3600.0),
    )?;
    let use_sim_time = ros_runtime::parameters::Descriptor::read_only("ROS's switch; unused here");
    parameters.declare("use_sim_time", false, use_sim_time)?;
    parameters.refuse_undeclared()?;

    let world = World::new(room.world, room.scenario, room.seed)
        .context("the room cannot be laid out as its parameters say")?;
    let mount = *room.camera.settings();
    let (mut session, first) = Session::new(world, room.camera, step_duration);
    let publishers = Publishers::new(&mut node)?;
    let resets = node.create_server::<Reset>("reset")?;
    let steps = node.create_server::<Step>("step")?;
    let commands = node.create_subscription::<ActionCommand>("action", reliable(1))?;
    node.start_parameter_services()?;
    info!(
        "the room is open: scenario {}, episode {}",
        session.scenario(),
        session.episode_number()
    );
    publishers.publish_mount(&mount, &session);
    publishers.publish(first, &session);

    let shutdown = node.shutdown().clone();
    node.block_on(shutdown.unless_requested(async {
        let mut reset_requests = resets.receive_request_stream();
        let mut step_requests = steps.receive_request_stream();
        let mut command_stream = pin!(commands.async_stream());
        let mut arrivals = pin!(publishers.arrivals().fuse());
        let mut pace = Pace::default();
        let publish = |executed: Option<Executed>, session: &Session, pace: &mut Pace| {
            if let Some(executed) = executed {
                publishers.publish(executed, session);
                if publishers.has_viewers() && pace.is_now() {
                    publishers.draw(session);
                }
            }
        };
        loop {
            let mut drawing_due = pin!(until(pace.due()).fuse());
            select! {
                request = step_requests.select_next_some() => match request {
                    Ok((id, request)) => {
                        let (response, executed) = session.step(&request);
                        if !response.success {
                            debug!("step refused: {}", response.message);
                        }
                        answer("step", steps.async_send_response(id, response)).await;
                        publish(executed, &session, &mut pace);
                    }
                    Err(error) => warn!("a request of step cannot be read: {error}"),
                },
                request = reset_requests.select_next_some() => match request {
                    Ok((id, request)) => {
                        let default: Option<String> = parameters.get("scenario");
                        let default = default.and_then(|name| name.parse().ok());
                        let default: Scenario = default.unwrap_or(session.scenario());
                        session.set_layout(layout(&parameters)?);
                        let client = id.writer_gid.to_bytes16();
                        let (response, executed) = session.reset(client, &request, default);
                        if !response.success {
                            warn!("reset refused: {}", response.message);
                        } else if executed.is_some() && !request.scenario.is_empty() {
                            // "Keep" is what the next reset without a scenario does.
                            let name = ParameterValue::String(request.scenario);
                            parameters.set("scenario", name)?;
                        }
                        answer("reset", resets.async_send_response(id, response)).await;
                        publish(executed, &session, &mut pace);
                    }
                    Err(error) => warn!("a request of reset cannot be read: {error}"),
                },
                command = command_stream.select_next_some() => match command {
                    Ok((command, _)) => match session.command(&command) {
                        Ok(executed) => publish(executed, &session, &mut pace),
                        Err(reason) => warn!("action refused: {reason}"),
                    },
                    Err(error) => warn!("an action cannot be read: {error}"),
                },
                () = arrivals.select_next_some() => if pace.is_now() {
                    publishers.draw(&session);
                },
                () = drawing_due => if pace.is_now() {
                    publishers.draw(&session);
                },
            }
        }
    }))
    .unwrap_or(Ok(()))
    .and_then(|()| Ok(shutdown.check()?))
}

/// Sends an answer, or gives it up: the client asks again.
///
/// The send window is full while a client that died has not been given up by DDS (its lease is some
/// 50 s); the others must not wait with it.
async fn answer<E: std::fmt::Display>(service: &str, sent: impl Future<Output = Result<(), E>>) {
    match tokio::time::timeout(SEND_TIMEOUT, sent).await {
        Ok(Ok(())) => {}
        Ok(Err(error)) => warn!("an answer of {service} could not be sent: {error}"),
        Err(_) => warn!("an answer of {service} could not be sent: a client does not read its own"),
    }
}
