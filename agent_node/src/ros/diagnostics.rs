//! The diagnostics of the node: `learner` during training, `driver` in deployment.

use std::{sync::Arc, time::Instant};

use parking_lot::{Mutex, MutexGuard};
use ros_runtime::diagnostics::{Diagnostics, Level, Report};

use super::console::recent_success;
use learning::training::Training;

/// The progress of training, reported on `/diagnostics`. Clones share the same state.
#[derive(Clone, Debug, Default)]
pub(super) struct LearnerState(Arc<Mutex<Learner>>);

#[derive(Clone, Copy, Debug, Default)]
struct Learner {
    /// Number of finished episodes.
    episode: u32,
    /// Number of episodes in the training run.
    episodes: u32,
    /// Number of steps in all episodes so far.
    steps: u64,
    steps_per_s: f64,
    update_us: f64,
    success_rate: f64,
}

impl LearnerState {
    /// Creates the state and registers it with `diagnostics` as `learner`.
    pub(super) fn reported_by(diagnostics: &Diagnostics) -> LearnerState {
        let state = LearnerState::default();
        let reported = state.clone();
        diagnostics.add("learner", move || reported.learner().report());
        state
    }

    /// Updates the state after an episode.
    pub(super) fn update(&self, training: &Training) {
        *self.learner() = Learner {
            episode: training.episode(),
            episodes: training.plan.episodes,
            steps: training.progress.total_steps,
            steps_per_s: training.steps_per_s(),
            update_us: training.update_us(),
            success_rate: recent_success(&training.progress.records),
        };
    }

    fn learner(&self) -> MutexGuard<'_, Learner> {
        self.0.lock()
    }
}

impl Learner {
    fn report(&self) -> Report {
        let Learner { episode, episodes, .. } = self;
        Report {
            level: Level::Ok,
            message: format!("{episode} of {episodes} episodes finished"),
            values: vec![
                ("episodes", episode.to_string()),
                ("steps", self.steps.to_string()),
                ("steps per second", format!("{:.0}", self.steps_per_s)),
                ("mean update time, us", format!("{:.0}", self.update_us)),
                ("recent success rate, %", format!("{:.1}", 100.0 * self.success_rate)),
            ],
        }
    }
}

/// The state of a deployment, reported on `/diagnostics`. Clones share the same state.
#[derive(Clone, Debug, Default)]
pub(super) struct DriverState(Arc<Mutex<Drive>>);

/// The images received and the commands sent so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Drive {
    /// Valid images received.
    pub(super) images: u64,
    /// Commands sent.
    pub(super) commands: u64,
    /// Valid images for which no command was sent: out of order, duplicate, taken during a move, or
    /// received while `action` had no subscriber.
    pub(super) ignored: u64,
    /// Images whose size, encoding or row length the policy does not accept.
    pub(super) invalid: u64,
    /// When the latest new image arrived; `None` before the first image and after a timeout.
    pub(super) latest: Option<Instant>,
    /// Whether `action` had a subscriber when the latest image arrived; `None` before the first
    /// image.
    pub(super) has_subscribers: Option<bool>,
}

impl DriverState {
    /// Creates the state and registers it with `diagnostics` as `driver`.
    pub(super) fn reported_by(diagnostics: &Diagnostics) -> DriverState {
        let state = DriverState::default();
        let reported = state.clone();
        diagnostics.add("driver", move || reported.drive().report());
        state
    }

    /// Locks the state to read or change it.
    pub(super) fn drive(&self) -> MutexGuard<'_, Drive> {
        self.0.lock()
    }
}

impl Drive {
    fn report(&self) -> Report {
        let (level, message) = match (self.latest, self.has_subscribers) {
            (None, _) => (Level::Warn, "waiting for images; not driving"),
            (Some(_), Some(true)) => (Level::Ok, "driving"),
            (Some(_), _) => (Level::Warn, "no subscriber on action; not driving"),
        };
        let age = self.latest.map(|latest| format!("{:.3}", latest.elapsed().as_secs_f64()));
        Report {
            level,
            message: message.to_owned(),
            values: vec![
                ("images", self.images.to_string()),
                ("commands", self.commands.to_string()),
                ("ignored images", self.ignored.to_string()),
                ("invalid images", self.invalid.to_string()),
                ("age of the latest image, s", age.unwrap_or_else(|| "none".to_owned())),
            ],
        }
    }
}
