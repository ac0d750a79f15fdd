//! A policy that drives a robot by nothing but its images: which of them it answers, and with what.

use std::time::Duration;

use task::{Action, Image};

use super::{dyna_q::Decision, policy::Policy};

/// An image so much older than the one before is of a robot that was started anew: its clock, too,
/// began again. What is less old has only been overtaken on the way.
const RESTART: Duration = Duration::from_secs(1);

/// A policy at the wheel.
///
/// It answers an image only once the robot has done what it was told last: an image that was taken
/// while it moves says where it was, not where it will be.
#[derive(Clone, Debug)]
pub struct Driver {
    policy: Policy,
    settle_time: Duration,
    /// The stamp of the latest image, since the robot's start.
    latest: Option<Duration>,
    /// The stamp of the image that was answered last, and the answer.
    answered: Option<(Duration, Action)>,
}

/// What an image is good for.
#[derive(Clone, Debug, PartialEq)]
pub enum Reaction {
    /// The robot shall do this.
    Drive(Decision),
    /// It still does what it was told last.
    Moving,
    /// A later image is known already.
    Late,
}

impl Driver {
    /// A driver who leaves the robot so much time for a move: from the image that is answered to
    /// one that shows the end of it.
    pub fn new(policy: Policy, settle_time: Duration) -> Driver {
        Driver { policy, settle_time, latest: None, answered: None }
    }

    /// An image, and when it was taken.
    pub fn see(&mut self, stamp: Duration, image: Image) -> Reaction {
        if self.latest.is_some_and(|latest| stamp + RESTART < latest) {
            (self.latest, self.answered) = (None, None);
        }
        if self.latest.is_some_and(|latest| stamp <= latest) {
            return Reaction::Late;
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
    use crate::{network::QNetwork, observation::input_size, sequence::Sequence, settings::Preset};

    fn image(brightness: u8) -> Image {
        Image::try_from([brightness; Image::BYTES].as_slice()).unwrap()
    }

    fn policy() -> Policy {
        let settings = Preset::Robust.settings();
        let inputs = input_size(settings.network.observation_frames);
        let mut random = Sequence::Weights.random(1);
        let network = QNetwork::new(inputs, &settings.network.hidden_layers, &mut random).unwrap();
        Policy::new(&network.randomized(2), &settings).unwrap()
    }

    fn at(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn it_answers_what_is_settled_and_nothing_twice() {
        let mut driver = Driver::new(policy(), at(100));
        let mut alone = policy();
        alone.begin(image(1));
        let first = alone.decide();
        assert_eq!(driver.see(at(5000), image(1)), Reaction::Drive(first.clone()));
        // What comes while the robot moves is neither answered nor remembered.
        assert_eq!(driver.see(at(5050), image(7)), Reaction::Moving);
        assert_eq!(driver.see(at(5050), image(7)), Reaction::Late);
        assert_eq!(driver.see(at(4990), image(7)), Reaction::Late);
        alone.observe(first.action, image(2));
        assert_eq!(driver.see(at(5100), image(2)), Reaction::Drive(alone.decide()));
    }

    #[test]
    fn a_robot_that_was_started_anew_has_no_past() {
        let mut driver = Driver::new(policy(), at(100));
        driver.see(at(60_000), image(1));
        driver.see(at(60_200), image(2));
        let mut fresh = policy();
        fresh.begin(image(3));
        assert_eq!(driver.see(at(500), image(3)), Reaction::Drive(fresh.decide()));
    }
}
