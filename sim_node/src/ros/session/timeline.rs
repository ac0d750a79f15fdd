//! The simulated time, in nanoseconds since the start of the simulator.

/// The simulated time: it advances with resets and steps, or follows the wall clock.
#[derive(Clone)]
pub(super) struct Timeline {
    /// Duration of a step or reset in nanoseconds.
    step_duration: u64,
    now: u64,
    /// The wall-clock time to follow, in nanoseconds; `None` if the time advances with resets and
    /// steps.
    wall_time: Option<u64>,
    /// When the latest step or reset was executed; nothing has moved since.
    last_change: u64,
}

impl Timeline {
    /// Creates a timeline at time 0. `step_duration` is in seconds.
    pub(super) fn new(step_duration: f64) -> Timeline {
        let step_duration = (step_duration * 1e9).round() as u64;
        Timeline { step_duration, now: 0, wall_time: None, last_change: 0 }
    }

    pub(super) fn now(&self) -> u64 {
        self.now
    }

    pub(super) fn wall_time(&self) -> Option<u64> {
        self.wall_time
    }

    pub(super) fn last_change(&self) -> u64 {
        self.last_change
    }

    /// Sets the wall-clock time. Simulated time follows it from the next call to
    /// [`advance`](Self::advance).
    pub(super) fn set_wall_time(&mut self, nanoseconds: u64) {
        self.wall_time = Some(nanoseconds);
    }

    /// Advances the time by one step, or to the wall-clock time.
    pub(super) fn advance(&mut self) {
        self.now = match self.wall_time {
            None => self.now.saturating_add(self.step_duration),
            // No two images have the same stamp.
            Some(wall_time) => wall_time.max(self.now + 1),
        };
    }

    /// Records that a step or reset was executed now.
    pub(super) fn record_change(&mut self) {
        self.last_change = self.now;
    }
}
