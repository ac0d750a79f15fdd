//! What the node says of itself on `/diagnostics`.

use std::{sync::Arc, time::Instant};

use parking_lot::{Mutex, MutexGuard};
use ros_runtime::diagnostics::{Diagnostics, Level, Report};

use super::console::recent_success;
use learning::training::Training;

/// How far a training is.
#[derive(Clone, Debug, Default)]
pub(super) struct LearnerState(Arc<Mutex<Learner>>);

#[derive(Clone, Copy, Debug, Default)]
struct Learner {
    episode: u32,
    episodes: u32,
    steps: u64,
    steps_per_s: f64,
    update_us: f64,
    success_rate: f64,
}

impl LearnerState {
    /// A state that is reported from now on.
    pub(super) fn reported_by(diagnostics: &Diagnostics) -> LearnerState {
        let state = LearnerState::default();
        let reported = state.clone();
        diagnostics.add("learner", move || reported.learner().report());
        state
    }

    /// An episode has ended.
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
            message: format!("{episode} of {episodes} episodes are done"),
            values: vec![
                ("episodes", episode.to_string()),
                ("steps", self.steps.to_string()),
                ("steps per second", format!("{:.0}", self.steps_per_s)),
                ("time of an update, us", format!("{:.0}", self.update_us)),
                ("recent success, %", format!("{:.1}", 100.0 * self.success_rate)),
            ],
        }
    }
}

/// Whether a driver drives.
#[derive(Clone, Debug, Default)]
pub(super) struct DriverState(Arc<Mutex<Drive>>);

/// What has become of the images so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Drive {
    pub(super) images: u64,
    pub(super) commands: u64,
    /// Images that came late, twice, while the robot moved, or while nobody heard the commands.
    pub(super) ignored: u64,
    /// Messages that are no image of this camera.
    pub(super) unreadable: u64,
    /// When the latest new image came; none if that is too long ago.
    pub(super) latest: Option<Instant>,
    /// Whether somebody hears the commands, as far as anybody has looked.
    pub(super) is_heard: Option<bool>,
}

impl DriverState {
    /// A state that is reported from now on.
    pub(super) fn reported_by(diagnostics: &Diagnostics) -> DriverState {
        let state = DriverState::default();
        let reported = state.clone();
        diagnostics.add("driver", move || reported.drive().report());
        state
    }

    /// What to change when something happens.
    pub(super) fn drive(&self) -> MutexGuard<'_, Drive> {
        self.0.lock()
    }
}

impl Drive {
    fn report(&self) -> Report {
        let (level, message) = match (self.latest, self.is_heard) {
            (None, _) => (Level::Warn, "waiting for images, and driving nowhere"),
            (Some(_), Some(true)) => (Level::Ok, "driving"),
            (Some(_), _) => (Level::Warn, "nobody hears the commands: driving nowhere"),
        };
        let age = self.latest.map(|latest| format!("{:.3}", latest.elapsed().as_secs_f64()));
        Report {
            level,
            message: message.to_owned(),
            values: vec![
                ("images", self.images.to_string()),
                ("commands", self.commands.to_string()),
                ("ignored images", self.ignored.to_string()),
                ("unreadable images", self.unreadable.to_string()),
                ("age of the latest image, s", age.unwrap_or_else(|| "none".to_owned())),
            ],
        }
    }
}
