//! A policy in deployment: decides which images in a stream to act on, and with which action.

use std::time::Duration;

use task::{Action, Image};

use super::{dyna_q::Decision, policy::Policy};

/// If an image is older than the latest one by more than this, the robot's clock has restarted. If
/// the difference is smaller, the image was delivered out of order.
const RESTART: Duration = Duration::from_secs(1);

/// Drives a robot with a policy, based on a stream of timestamped images.
///
/// The driver acts on an image only if it was taken after the robot completed the previous action:
/// an image taken during a move shows an intermediate pose.
///
/// # Examples
///
/// ```
/// use std::time::Duration;
///
/// use learning::{
///     architectures::backend,
///     driver::{Driver, Reaction},
///     policy::Policy,
///     settings::Preset,
/// };
/// use task::{Image, Random};
///
/// let settings = Preset::Robust.settings();
/// let backend = backend(&settings, &mut Random::from_key([0; 4]))?;
/// let policy = Policy::new(backend.train().clone_box(), &settings);
/// let mut driver = Driver::new(policy, Duration::from_millis(100));
///
/// let image = Image::try_from(vec![0u8; Image::BYTES])?;
/// let reaction = driver.process_image(Duration::from_millis(5000), image.clone());
/// assert!(matches!(reaction, Reaction::Drive(_)));
/// assert_eq!(driver.process_image(Duration::from_millis(5050), image.clone()), Reaction::Moving);
/// assert_eq!(driver.process_image(Duration::from_millis(5020), image), Reaction::OutOfOrder);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Driver {
    policy: Policy,
    settle_time: Duration,
    /// The stamp of the latest image since the robot's clock restarted.
    latest: Option<Duration>,
    /// The stamp of the last image that was acted on, and the action taken.
    answered: Option<(Duration, Action)>,
}

/// The response of a [`Driver`] to an image.
#[derive(Clone, Debug, PartialEq)]
pub enum Reaction {
    /// The robot must take the action in this decision.
    Drive(Decision),
    /// Ignored: the robot is still executing the previous action.
    Moving,
    /// Ignored: a duplicate, or older than an image that was already processed.
    OutOfOrder,
}

impl Driver {
    /// Creates a driver that has not received any images.
    ///
    /// `settle_time` is the minimum time between the stamp of an image that is acted on and the
    /// stamp of the first image that shows the completed action.
    pub fn new(policy: Policy, settle_time: Duration) -> Driver {
        Driver { policy, settle_time, latest: None, answered: None }
    }

    /// Processes an image that was taken at `stamp`, a time on the robot's clock.
    ///
    /// If the clock has restarted, a new episode begins.
    pub fn process_image(&mut self, stamp: Duration, image: Image) -> Reaction {
        if self.latest.is_some_and(|latest| stamp + RESTART < latest) {
            (self.latest, self.answered) = (None, None);
        }
        if self.latest.is_some_and(|latest| stamp <= latest) {
            return Reaction::OutOfOrder;
        }
        self.latest = Some(stamp);
        match self.answered {
            Some((answered, _)) if stamp < answered + self.settle_time => return Reaction::Moving,
            Some((_, action)) => self.policy.observe(action, image),
            None => self.policy.begin(image),
        }
        let decision = self.policy.decide();
        self.answered = Some((stamp, decision.action));
        Reaction::Drive(decision)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        network::{QNetwork, Shape},
        perceptron::Perceptron,
        sequence::Sequence,
        settings::Preset,
    };

    fn image(brightness: u8) -> Image {
        Image::try_from([brightness; Image::BYTES].as_slice()).unwrap()
    }

    fn policy() -> Policy {
        let settings = Preset::Robust.settings();
        let mut random = Sequence::Weights.random(1);
        let network = QNetwork::new(&Shape::of(&settings.network), &mut random).unwrap();
        let network = Perceptron::new(&network.randomized(2)).unwrap();
        Policy::new(Box::new(network), &settings)
    }

    fn at(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn acts_only_on_new_images_taken_after_the_settle_time() {
        let mut driver = Driver::new(policy(), at(100));
        let mut reference = policy();
        reference.begin(image(1));
        let first = reference.decide();
        assert_eq!(driver.process_image(at(5000), image(1)), Reaction::Drive(first.clone()));
        // An image taken while the robot moves is neither acted on nor added to the observation.
        assert_eq!(driver.process_image(at(5050), image(7)), Reaction::Moving);
        assert_eq!(driver.process_image(at(5050), image(7)), Reaction::OutOfOrder);
        assert_eq!(driver.process_image(at(4990), image(7)), Reaction::OutOfOrder);
        reference.observe(first.action, image(2));
        assert_eq!(driver.process_image(at(5100), image(2)), Reaction::Drive(reference.decide()));
    }

    #[test]
    fn begins_a_new_episode_when_the_clock_restarts() {
        let mut driver = Driver::new(policy(), at(100));
        driver.process_image(at(60_000), image(1));
        driver.process_image(at(60_200), image(2));
        let mut reference = policy();
        reference.begin(image(3));
        assert_eq!(driver.process_image(at(500), image(3)), Reaction::Drive(reference.decide()));
    }
}
