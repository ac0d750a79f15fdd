//! The robustness of a policy: its evaluation under each perturbation of the world.

use serde::{Deserialize, Serialize};

use super::measures::Evaluation;

/// The name of the evaluation without perturbations.
pub const CLEAN: &str = "clean";
/// The name of the evaluations with all perturbations together.
pub const ALL: &str = "all";

/// The evaluation of a policy under a perturbation: an element of `robustness.json`.
///
/// # Examples
///
/// ```
/// use task::{Evaluation, EvaluationEpisode, RobustnessRow};
///
/// let episode = EvaluationEpisode { episode: 0, steps: 20, blocked: 1, succeeded: true };
/// let evaluation = Evaluation::new("empty", 1, 200, &[episode], None);
/// let row = RobustnessRow::new("camera.noise", "mild", &evaluation);
/// assert_eq!((row.success_rate, row.blocked_per_100_steps), (1.0, 5.0));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobustnessRow {
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the perturbation: its parameters, [`CLEAN`] or [`ALL`].
    pub perturbation: String,
    /// Level of the perturbation: `none`, `mild` or `strong`.
    pub level: String,
    /// Number of evaluation episodes.
    pub episodes: u32,
    /// Fraction of successful episodes, 0 to 1.
    pub success_rate: f64,
    /// Blocked moves per 100 steps.
    pub blocked_per_100_steps: f64,
    /// Fraction of collision-free episodes, 0 to 1.
    pub collision_free_rate: f64,
    /// Mean number of steps of the successful episodes; null if no episode succeeded.
    pub mean_steps: Option<f64>,
    /// See [`Evaluation::optimality_ratio`].
    pub optimality_ratio: Option<f64>,
}

impl RobustnessRow {
    /// Returns the row for an evaluation.
    pub fn new(perturbation: &str, level: &str, evaluation: &Evaluation) -> RobustnessRow {
        RobustnessRow {
            scenario: evaluation.scenario.clone(),
            perturbation: perturbation.to_owned(),
            level: level.to_owned(),
            episodes: evaluation.episodes,
            success_rate: evaluation.success_rate,
            blocked_per_100_steps: evaluation.blocked_per_100_steps,
            collision_free_rate: evaluation.collision_free_rate,
            mean_steps: evaluation.mean_steps,
            optimality_ratio: evaluation.optimality_ratio,
        }
    }
}
