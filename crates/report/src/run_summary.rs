//! The facts about a run that the report and its tables show.

/// Configuration and duration of a run, as in `summary.json`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunSummary<'a> {
    /// Training scenario.
    pub scenario: &'a str,
    /// Preset that provides the default values of the parameters.
    pub preset: &'a str,
    /// Seed of the run.
    pub seed: u64,
    /// Planned number of training episodes; if there are fewer records, training is incomplete.
    pub episodes: u32,
    /// Total number of training steps.
    pub steps: u64,
    /// Wall time in seconds, from the first reset to the last update.
    pub wall_s: f64,
    /// `steps / wall_s`.
    pub steps_per_s: f64,
    /// Mean update time in microseconds; `None` if there was no update.
    pub update_us: Option<f64>,
}
