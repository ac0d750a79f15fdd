//! `agent_node drive`: deploys a trained model on a robot or simulator.
//!
//! The node subscribes to `camera/image` and publishes commands on `action`. It does not use
//! services.

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

/// Drives a robot with a trained model until the node shuts down.
///
/// # Errors
///
/// Returns an error if the arguments, parameters or model are invalid, or if the node cannot be
/// started.
pub fn drive(arguments: &Arguments) -> anyhow::Result<()> {
    let mut node = Node::new("agent_node", arguments, evac_msgs::DEFINITIONS)?;
    let parameters = node.parameters().clone();
    let model = TrainedModel::declare(&parameters)?;
    let Options { settle_time, image_timeout } = Options::declare(&parameters)?;
    let driver = Driver::new(model.policy()?, Duration::from_secs_f64(settle_time));
    let state = DriverState::reported_by(node.diagnostics());
    node.start_services()?;

    // Depth 1 and best effort: only the latest image matters, and a lost image is superseded by the
    // next one.
    let images = node.create_subscription::<ImageMessage>("camera/image", best_effort(1))?;
    let actions = node.create_publisher("action", reliable(1))?;
    let q_values = node.create_publisher("q_values", reliable(10))?;
    let timeout = Duration::from_secs_f64(image_timeout);
    let mut drive_loop = DriveLoop { driver, actions, q_values, state, timeout };
    node.notify_ready();
    info!("waiting for images on {}", node.naming().resolve("camera/image")?);
    let shutdown = node.shutdown().clone();
    node.block_on(shutdown.unless_requested(async {
        loop {
            match tokio::time::timeout(timeout, images.async_take()).await {
                Ok(Ok((message, _))) => drive_loop.process_image(message),
                Ok(Err(error)) => warn!("cannot deserialize a message on camera/image: {error}"),
                Err(_) => {}
            }
            drive_loop.check_timeout();
        }
    }));
    let drive = *drive_loop.state.drive();
    info!("received {} images, sent {} commands", drive.images, drive.commands);
    Ok(())
}

/// The parameters of `drive`, in addition to those of the model.
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
                "minimum difference, in seconds, between the stamps of two images that the node \
                 acts on; must exceed the command latency plus the duration of the \
                 robot's longest move, because images in between are assumed to show the robot in \
                 motion and are ignored",
            )
            .range(0.0..=3600.0),
        )?;
        let image_timeout = parameters.declare(
            "image_timeout",
            2.0,
            Descriptor::read_only(
                "time without a new image, in seconds, after which the node logs a warning and \
                 reports WARN on /diagnostics",
            )
            .range(0.001..=3600.0),
        )?;
        parameters.reject_undeclared()?;
        Ok(Options { settle_time, image_timeout })
    }
}

/// Declares the parameters of [`drive`]; `model` may be empty.
pub(super) fn declare_parameters(parameters: &Parameters) -> anyhow::Result<()> {
    TrainedModel::declare_optional(parameters)?;
    Options::declare(parameters)?;
    Ok(())
}

/// Publishes a command for each camera image that is not ignored.
struct DriveLoop {
    driver: Driver,
    actions: Publisher<ActionCommand>,
    q_values: Publisher<QValues>,
    state: DriverState,
    /// The parameter `image_timeout`.
    timeout: Duration,
}

impl DriveLoop {
    /// Logs a warning, once, if no new image has arrived within the timeout.
    fn check_timeout(&mut self) {
        let mut drive = self.state.drive();
        if drive.latest.take_if(|latest| latest.elapsed() >= self.timeout).is_some() {
            let seconds = self.timeout.as_secs_f64();
            warn!("no new image for {seconds} s; not driving");
        }
    }

    /// Publishes a command for an image unless the image is invalid or ignored.
    fn process_image(&mut self, message: ImageMessage) {
        let mut drive = self.state.drive();
        let (image, header) = match image(message) {
            Ok(image) => image,
            Err(error) => {
                // A camera with the wrong format sends every image in that format: log only the
                // first.
                if drive.invalid == 0 {
                    warn!("{error}");
                }
                drive.invalid += 1;
                return;
            }
        };
        drive.images += 1;
        let has_subscribers = self.actions.has_subscribers();
        if drive.has_subscribers.replace(has_subscribers) != Some(has_subscribers) {
            match has_subscribers {
                true => info!("action has a subscriber"),
                false => warn!("no subscriber on action; not driving"),
            }
        }
        let stamp = header.stamp;
        // The driver assumes that the robot executes every command, so it must not process images
        // while `action` has no subscriber.
        let reaction =
            has_subscribers.then(|| self.driver.process_image(since_epoch(stamp), image));
        if reaction == Some(Reaction::OutOfOrder) {
            drive.ignored += 1;
            return debug!("ignored an out-of-order or duplicate image with stamp {stamp:?}");
        }
        if drive.latest.replace(Instant::now()).is_none() {
            info!("receiving images");
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

/// Returns the time of a stamp since the epoch of its clock; zero for a stamp before the epoch.
fn since_epoch(stamp: Time) -> Duration {
    let seconds = Duration::from_secs(u64::try_from(stamp.sec).unwrap_or(0));
    seconds + Duration::from_nanos(stamp.nanosec.into())
}
