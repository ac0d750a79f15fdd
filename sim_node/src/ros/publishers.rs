//! What the node publishes of everything that is executed.

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

/// The shortest time between two drawings: RViz, too, draws 30 times a second.
const DRAWING_INTERVAL: Duration = Duration::from_millis(33);

/// Every topic of the node. What nobody reads is not made.
///
/// The path and the scene are drawings, for people: they follow every reset and step, but where
/// thousands of steps are taken in a second only 30 times. They are large, a path grows with its
/// episode, and RustDDS keeps for six seconds what it has sent: with a drawing for each step it would
/// soon be hundreds of megabytes, and the answers to the agent would wait behind them.
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
            // The depths of tf2_ros.
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

    /// Publishes what never changes. The middleware keeps it for those who come later.
    pub(super) fn publish_mount(&self, camera: &CameraSettings, session: &Session) {
        self.static_transforms.publish(messages::mount(camera, session.now()));
    }

    /// Publishes what was executed, but for the drawings. The time comes first, and then where
    /// things are: whoever gets an image may look that up.
    pub(super) fn publish(&self, executed: EpisodeStatus, session: &Session) {
        self.publish_frame(session);
        self.statuses.publish_with(|| executed);
    }

    /// Publishes what the camera sees, and where it stands.
    pub(super) fn publish_frame(&self, session: &Session) {
        let (now, robot) = (session.now(), session.world().robot());
        self.clock.publish_with(|| Clock { clock: now });
        self.transforms.publish_with(|| messages::robot(robot, now));
        self.odometry.publish_with(|| messages::odometry(robot, now));
        self.camera_infos.publish_with(|| messages::camera_info(now));
        self.images.publish_with(|| session.image());
    }

    /// Whether anybody looks at a drawing.
    pub(super) fn has_viewers(&self) -> bool {
        self.path.has_readers() || self.scene.has_readers()
    }

    /// Somebody may have come who does not know the scene.
    pub(super) fn arrivals(&self) -> impl Stream<Item = ()> {
        self.scene.arrivals()
    }

    /// Publishes the drawings.
    pub(super) fn draw(&self, session: &Session) {
        self.path.publish_with(|| messages::path(session.path(), session.now()));
        self.scene.publish_with(|| messages::scene(session.world(), session.now()));
    }
}

/// When to draw: at once, unless the last drawing was made a moment ago.
#[derive(Default)]
pub(super) struct Pace {
    latest: Option<Instant>,
    due: Option<Instant>,
}

impl Pace {
    /// There is something new: whether it is to be drawn now. If not, it will be due.
    pub(super) fn is_now(&mut self) -> bool {
        let now = Instant::now();
        match self.latest.map(|latest| latest + DRAWING_INTERVAL).filter(|earliest| *earliest > now)
        {
            None => {
                *self = Pace { latest: Some(now), due: None };
                true
            }
            earliest => {
                self.due = earliest;
                false
            }
        }
    }

    /// When something is due that has not been drawn.
    pub(super) fn due(&self) -> Option<Instant> {
        self.due
    }
}

/// Waits for a moment, or for ever.
pub(super) async fn until(moment: Option<Instant>) {
    match moment {
        Some(moment) => sleep_until(moment).await,
        None => future::pending().await,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawings_keep_their_distance_and_the_last_one_is_not_forgotten() {
        let mut pace = Pace::default();
        assert!(pace.is_now());
        assert_eq!(pace.due(), None);
        let first = pace.latest.unwrap();
        assert!(!pace.is_now() && !pace.is_now());
        assert_eq!(pace.due(), Some(first + DRAWING_INTERVAL));
        pace.latest = Some(first - DRAWING_INTERVAL);
        assert!(pace.is_now());
        assert_eq!(pace.due(), None);
    }
}
