//! The publishers of the node.

use std::{future, time::Duration};

use evac_msgs::EpisodeStatus;
use futures::Stream;
use ros_interfaces::{
    nav_msgs::{Odometry, Path},
    rosgraph_msgs::Clock,
    sensor_msgs::CameraInfo,
    sensor_msgs::Image,
    tf2_msgs::TFMessage,
    visualization_msgs::MarkerArray,
};
use ros_runtime::{
    Node, Publisher,
    node::{LatchedPublisher, NodeError, latched, reliable},
};
use tokio::time::{Instant, sleep_until};

use super::{messages, session::Session};
use crate::camera::CameraSettings;

/// Minimum time between two visualizations: RViz renders 30 times per second.
const VISUALIZATION_INTERVAL: Duration = Duration::from_millis(33);

/// The publishers of all topics. Images and other large messages are created only if their topic
/// has subscribers.
///
/// The path and the scene are for visualization: they are published after each reset and step, but
/// at most 30 times per second. They are large, the path grows during an episode, and RustDDS keeps
/// sent messages for six seconds. At thousands of steps per second, a visualization of each step
/// would take hundreds of megabytes and delay the responses to the agent.
pub(super) struct Publishers {
    clock: Publisher<Clock>,
    transforms: Publisher<TFMessage>,
    static_transforms: Publisher<TFMessage>,
    odometry: Publisher<Odometry>,
    images: Publisher<Image>,
    camera_infos: Publisher<CameraInfo>,
    statuses: Publisher<EpisodeStatus>,
    path: Publisher<Path>,
    scene: LatchedPublisher<MarkerArray>,
}

impl Publishers {
    pub(super) fn new(node: &mut Node) -> Result<Publishers, NodeError> {
        Ok(Publishers {
            clock: node.create_publisher("clock", reliable(10))?,
            // The depths are those of tf2_ros.
            transforms: node.create_publisher("tf", reliable(100))?,
            static_transforms: node.create_publisher("tf_static", latched(1))?,
            odometry: node.create_publisher("odom", reliable(10))?,
            images: node.create_publisher("camera/image", reliable(5))?,
            camera_infos: node.create_publisher("camera/camera_info", reliable(5))?,
            statuses: node.create_publisher("episode", reliable(10))?,
            path: node.create_publisher("path", reliable(1))?,
            scene: node.create_latched_publisher("scene")?,
        })
    }

    /// Publishes the camera mount on `tf_static`, which is latched.
    pub(super) fn publish_mount(&self, camera: &CameraSettings, session: &Session) {
        self.static_transforms.publish(messages::mount(camera, session.now()));
    }

    /// Publishes the status after a reset or step.
    pub(super) fn publish_status(&self, executed: EpisodeStatus) {
        self.statuses.publish_with(|| executed);
    }

    /// Publishes time and pose. The image with the same stamp must follow later, because its
    /// subscribers may look them up.
    pub(super) fn publish_pose(&self, session: &Session) {
        let (now, robot) = (session.now(), session.world().robot());
        self.clock.publish_with(|| Clock { clock: now });
        self.transforms.publish_with(|| messages::robot(robot, now));
        let odometry = session.simulation().odometry();
        self.odometry.publish_with(|| messages::odometry(odometry, now));
    }

    /// Publishes the current image and its camera info.
    pub(super) fn publish_image(&self, session: &Session) {
        self.camera_infos.publish_with(|| messages::camera_info(session.now()));
        self.images.publish_with(|| session.image());
    }

    /// Publishes an image that was taken earlier and its camera info.
    pub(super) fn publish_earlier_image(&self, image: Image) {
        self.camera_infos.publish_with(|| messages::camera_info(image.header.stamp));
        self.images.publish_with(|| image);
    }

    /// Returns whether the visualization has subscribers.
    pub(super) fn has_visualization_subscribers(&self) -> bool {
        self.path.has_subscribers() || self.scene.has_subscribers()
    }

    /// Yields an item whenever a new subscriber may lack the scene.
    pub(super) fn arrivals(&self) -> impl Stream<Item = ()> {
        self.scene.arrivals()
    }

    /// Publishes the visualization: path and scene.
    pub(super) fn publish_visualization(&self, session: &Session) {
        self.path.publish_with(|| messages::path(session.path(), session.now()));
        self.scene.publish_with(|| messages::scene(session.world(), session.now()));
    }
}

/// Limits the rate of visualizations and delays the last one instead of dropping it.
#[derive(Default)]
pub(super) struct Throttle {
    latest: Option<Instant>,
    due: Option<Instant>,
}

impl Throttle {
    /// Returns whether to publish a new state now. If not, the state becomes due later.
    pub(super) fn request(&mut self) -> bool {
        let now = Instant::now();
        let earliest = self.latest.map(|latest| latest + VISUALIZATION_INTERVAL);
        match earliest.filter(|earliest| *earliest > now) {
            None => {
                *self = Throttle { latest: Some(now), due: None };
                true
            }
            earliest => {
                self.due = earliest;
                false
            }
        }
    }

    /// Returns when the delayed state is due, if there is one.
    pub(super) fn due(&self) -> Option<Instant> {
        self.due
    }
}

/// Waits until `time`, or forever if it is `None`.
pub(super) async fn wait_until(time: Option<Instant>) {
    match time {
        Some(time) => sleep_until(time).await,
        None => future::pending().await,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_throttle_delays_the_last_state_instead_of_dropping_it() {
        let mut throttle = Throttle::default();
        assert!(throttle.request());
        assert_eq!(throttle.due(), None);
        let first = throttle.latest.unwrap();
        assert!(!throttle.request() && !throttle.request());
        assert_eq!(throttle.due(), Some(first + VISUALIZATION_INTERVAL));
        throttle.latest = Some(first - VISUALIZATION_INTERVAL);
        assert!(throttle.request());
        assert_eq!(throttle.due(), None);
    }
}
