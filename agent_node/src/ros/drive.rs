//! Deployment: the agent hears only `camera/image` and says only `action`.

use std::time::{Duration, Instant};

use evac_msgs::{ActionCommand, QValues};
use log::{debug, info, warn};
use ros_interfaces::{
    builtin_interfaces::Time, sensor_msgs::Image as ImageMessage, std_msgs::Header,
};
use ros_runtime::{
    Arguments, Node, Publisher,
    node::{best_effort, reliable},
    parameters::{Descriptor, Parameters},
};

use super::{conversation::image, diagnostics::DriverState, parameters::TrainedModel};
use learning::driver::{Driver, Reaction};

/// Drives a robot with a trained model, until the node is told to end.
pub fn drive(arguments: &Arguments) -> anyhow::Result<()> {
    let mut node = Node::new("agent_node", arguments, evac_msgs::DEFINITIONS)?;
    let parameters = node.parameters().clone();
    let model = TrainedModel::declare(&parameters)?;
    let Options { settle_time, image_timeout } = Options::declare(&parameters)?;
    let driver = Driver::new(model.policy()?, Duration::from_secs_f64(settle_time));
    let state = DriverState::reported_by(node.diagnostics());
    node.start_services()?;

    // Only the latest counts: what is lost is followed by another.
    let images = node.create_subscription::<ImageMessage>("camera/image", best_effort(1))?;
    let actions = node.create_publisher("action", reliable(1))?;
    let q_values = node.create_publisher("q_values", reliable(10))?;
    let timeout = Duration::from_secs_f64(image_timeout);
    let mut wheel = Wheel { driver, actions, q_values, state, timeout };
    node.tell_ready();
    info!("waiting for images on {}", node.naming().resolve("camera/image")?);
    let shutdown = node.shutdown().clone();
    node.block_on(shutdown.unless_requested(async {
        loop {
            match tokio::time::timeout(timeout, images.async_take()).await {
                Ok(Ok((message, _))) => wheel.turn(message),
                Ok(Err(error)) => warn!("an image cannot be read: {error}"),
                Err(_) => {}
            }
            wheel.notice_silence();
        }
    }));
    let drive = *wheel.state.drive();
    info!("{} images were seen, {} of them answered", drive.images, drive.commands);
    Ok(())
}

/// The parameters of a drive, besides those of its model.
struct Options {
    settle_time: f64,
    image_timeout: f64,
}

impl Options {
    fn declare(parameters: &Parameters) -> anyhow::Result<Options> {
        let settle_time = parameters.declare(
            "settle_time",
            0.1,
            Descriptor::read_only(
                "how long after an image that was answered the next one is, in seconds by the stamps: \
                 the way of the command, and the robot's longest move",
            )
            .range(0.0..=3600.0),
        )?;
        let image_timeout = parameters.declare(
            "image_timeout",
            2.0,
            Descriptor::read_only("warn after this time without an image, in seconds")
                .range(0.001..=3600.0),
        )?;
        parameters.refuse_undeclared()?;
        Ok(Options { settle_time, image_timeout })
    }
}

/// Declares what [`drive`] declares; the model may be missing.
pub(super) fn declare_parameters(parameters: &Parameters) -> anyhow::Result<()> {
    TrainedModel::declare_optional(parameters)?;
    Options::declare(parameters)?;
    Ok(())
}

/// What turns images into commands.
struct Wheel {
    driver: Driver,
    actions: Publisher<ActionCommand>,
    q_values: Publisher<QValues>,
    state: DriverState,
    /// How long there may be no new image.
    timeout: Duration,
}

impl Wheel {
    /// Says so if there was no new image for a while, whatever else came.
    fn notice_silence(&mut self) {
        let mut drive = self.state.drive();
        if drive.latest.take_if(|latest| latest.elapsed() >= self.timeout).is_some() {
            let seconds = self.timeout.as_secs_f64();
            warn!("no new image for {seconds} s: waiting, and driving nowhere");
        }
    }

    fn turn(&mut self, message: ImageMessage) {
        let mut drive = self.state.drive();
        let (seen, header) = match image(message) {
            Ok(image) => image,
            Err(error) => {
                // Whoever sends such images sends many.
                if drive.unreadable == 0 {
                    warn!("{error}");
                }
                drive.unreadable += 1;
                return;
            }
        };
        drive.images += 1;
        let is_heard = self.actions.has_readers();
        if drive.is_heard.replace(is_heard) != Some(is_heard) {
            match is_heard {
                true => info!("somebody hears the commands"),
                false => warn!("nobody hears the commands: waiting, and driving nowhere"),
            }
        }
        let stamp = header.stamp;
        // To answer an image that nobody hears the answer of would be to believe in a move.
        let reaction = is_heard.then(|| self.driver.see(since_epoch(stamp), seen));
        if reaction == Some(Reaction::Late) {
            drive.ignored += 1;
            return debug!("the image of {stamp:?} comes late, or for the second time");
        }
        if drive.latest.replace(Instant::now()).is_none() {
            info!("there are images");
        }
        let Some(Reaction::Drive(decision)) = reaction else {
            drive.ignored += 1;
            return;
        };
        drive.commands += 1;
        drop(drive);
        let action = decision.action.index();
        self.actions.publish_with(|| ActionCommand {
            header: Header { stamp, ..Header::default() },
            action,
            sent_by_service: false,
        });
        let learning::dyna_q::Decision { values, explored, .. } = decision;
        self.q_values.publish_with(|| QValues { header, values, action, explored });
    }
}

/// A stamp as what has passed since its clock's zero; one before that is the zero.
fn since_epoch(stamp: Time) -> Duration {
    let seconds = Duration::from_secs(u64::try_from(stamp.sec).unwrap_or(0));
    seconds + Duration::from_nanos(stamp.nanosec.into())
}
