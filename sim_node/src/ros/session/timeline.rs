//! The time of the simulation, in nanoseconds since the start.

/// The time, which steps and resets let pass, or which follows a clock on the wall.
#[derive(Clone)]
pub(super) struct Timeline {
    /// How long a step or a reset takes.
    step_duration: u64,
    now: u64,
    /// What a clock on the wall says, where the time follows it.
    wall: Option<u64>,
    /// Since when everything stands where it stands now.
    settled: u64,
}

impl Timeline {
    /// The start of time. `step_duration` is in seconds.
    pub(super) fn new(step_duration: f64) -> Timeline {
        let step_duration = (step_duration * 1e9).round() as u64;
        Timeline { step_duration, now: 0, wall: None, settled: 0 }
    }

    pub(super) fn now(&self) -> u64 {
        self.now
    }

    pub(super) fn wall(&self) -> Option<u64> {
        self.wall
    }

    pub(super) fn settled(&self) -> u64 {
        self.settled
    }

    /// From now on the time follows a clock on the wall, which says this.
    pub(super) fn follow(&mut self, wall: u64) {
        self.wall = Some(wall);
    }

    /// Lets the time of a step or reset pass, or that of the clock on the wall.
    pub(super) fn pass(&mut self) {
        self.now = match self.wall {
            None => self.now.saturating_add(self.step_duration),
            // Two images never have the same stamp.
            Some(wall) => wall.max(self.now + 1),
        };
    }

    /// Everything stands now as it will until the next step.
    pub(super) fn settle(&mut self) {
        self.settled = self.now;
    }
}
