//! Evaluation results, computed identically in process and over DDS.

use serde::{Deserialize, Serialize};

/// The result of one evaluation episode.
///
/// # Examples
///
/// ```
/// use task::EvaluationEpisode;
///
/// let episode = EvaluationEpisode { episode: 0, steps: 12, blocked: 0, succeeded: true };
/// let is_collision_free = episode.blocked == 0;
/// assert!(is_collision_free && episode.succeeded);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluationEpisode {
    /// Index of the episode, starting at 0.
    pub episode: u32,
    /// Number of steps, including blocked ones.
    pub steps: u32,
    /// Number of blocked steps.
    pub blocked: u32,
    /// Whether the robot reached the exit.
    pub succeeded: bool,
}

/// The result of an evaluation: the contents of `evaluation.json` and of the `evaluation` field in
/// `summary.json`.
///
/// # Examples
///
/// ```
/// use task::{Evaluation, EvaluationEpisode};
///
/// let episodes = [
///     EvaluationEpisode { episode: 0, steps: 10, blocked: 0, succeeded: true },
///     EvaluationEpisode { episode: 1, steps: 200, blocked: 190, succeeded: false },
/// ];
/// let shortest_paths = [Some(8), Some(9)];
/// let evaluation = Evaluation::new("empty", 1, 200, &episodes, Some(&shortest_paths));
/// assert_eq!(evaluation.success_rate, 0.5);
/// assert_eq!(evaluation.oracle_mean_steps, Some(8.5));
/// assert_eq!(evaluation.optimality_ratio, Some(10.0 / 8.0));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Name of the evaluated scenario, or [`MIXED`](crate::seeds::MIXED).
    pub scenario: String,
    /// Number of episodes.
    pub episodes: u32,
    /// Number of episodes in which the robot reached the exit within `max_steps`.
    pub successes: u32,
    /// `successes / episodes`, 0 to 1.
    pub success_rate: f64,
    /// Step limit per episode; an episode fails if the robot does not reach the exit within this
    /// limit.
    pub max_steps: u32,
    /// Seed of the evaluation, from which [`episode_seed`](crate::seeds::episode_seed) derives the
    /// episode seeds.
    pub seed: u64,
    /// Mean number of steps in the successful episodes; null if no episode succeeded.
    pub mean_steps: Option<f64>,
    /// Mean length of the full-knowledge shortest paths over all episodes, in steps; null if the
    /// length is unknown for any episode, e.g. because obstacles move.
    pub oracle_mean_steps: Option<f64>,
    /// Total steps of the successful episodes divided by the total length of the full-knowledge
    /// shortest paths of the same episodes; null if `oracle_mean_steps` is null or no episode
    /// succeeded.
    pub optimality_ratio: Option<f64>,
    /// Blocked moves per 100 steps, over all episodes.
    pub blocked_per_100_steps: f64,
    /// Fraction of collision-free episodes (those without a blocked move), 0 to 1.
    pub collision_free_rate: f64,
}

impl Evaluation {
    /// Summarizes the episodes of an evaluation.
    ///
    /// `shortest_paths` holds the length of the full-knowledge shortest path of each episode, in
    /// steps. If it is absent, has a different length from `episodes`, or lacks the path length for
    /// any episode, `oracle_mean_steps` and `optimality_ratio` are `None`.
    ///
    /// # Panics
    ///
    /// Panics if every length in `shortest_paths` is known and the index of a successful episode is
    /// out of range for `episodes`.
    pub fn new(
        scenario: &str,
        seed: u64,
        max_steps: u32,
        episodes: &[EvaluationEpisode],
        shortest_paths: Option<&[Option<u32>]>,
    ) -> Evaluation {
        let count = episodes.len() as f64;
        let share = |number: usize| {
            if episodes.is_empty() { 0.0 } else { number as f64 / count }
        };
        let succeeded: Vec<&EvaluationEpisode> = episodes.iter().filter(|e| e.succeeded).collect();
        let steps: u64 = episodes.iter().map(|e| u64::from(e.steps)).sum();
        let blocked: u64 = episodes.iter().map(|e| u64::from(e.blocked)).sum();
        let success_steps: u64 = succeeded.iter().map(|e| u64::from(e.steps)).sum();
        // `None` if any length is unknown: a mean over a subset of the episodes is not comparable.
        let shortest: Option<Vec<u64>> = shortest_paths
            .filter(|shortest| shortest.len() == episodes.len() && !shortest.is_empty())
            .and_then(|shortest| shortest.iter().map(|steps| steps.map(u64::from)).collect());
        let shortest_of_successes: Option<u64> =
            shortest.as_ref().map(|all| succeeded.iter().map(|e| all[e.episode as usize]).sum());
        Evaluation {
            scenario: scenario.to_owned(),
            episodes: episodes.len() as u32,
            successes: succeeded.len() as u32,
            success_rate: share(succeeded.len()),
            max_steps,
            seed,
            mean_steps: ratio(success_steps, succeeded.len() as u64),
            oracle_mean_steps: shortest.and_then(|all| ratio(all.iter().sum(), all.len() as u64)),
            optimality_ratio: shortest_of_successes
                .and_then(|shortest| ratio(success_steps, shortest)),
            blocked_per_100_steps: ratio(100 * blocked, steps).unwrap_or(0.0),
            collision_free_rate: share(episodes.iter().filter(|e| e.blocked == 0).count()),
        }
    }
}

/// Returns the quotient, or `None` if the denominator is 0.
fn ratio(numerator: u64, denominator: u64) -> Option<f64> {
    (denominator > 0).then(|| numerator as f64 / denominator as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summarizes_an_evaluation() {
        let episode = |episode, steps, blocked, succeeded| EvaluationEpisode {
            episode,
            steps,
            blocked,
            succeeded,
        };
        let episodes = [
            episode(0, 10, 0, true),
            episode(1, 200, 190, false),
            episode(2, 14, 1, true),
            episode(3, 6, 0, true),
        ];
        let shortest = [Some(8), Some(9), Some(12), Some(5)];
        let evaluation = Evaluation::new("empty", 1, 200, &episodes, Some(&shortest));
        assert_eq!((evaluation.successes, evaluation.success_rate), (3, 0.75));
        assert_eq!(evaluation.mean_steps, Some(10.0));
        assert_eq!(evaluation.oracle_mean_steps, Some(8.5));
        assert_eq!(evaluation.optimality_ratio, Some(30.0 / 25.0));
        assert_eq!(evaluation.blocked_per_100_steps, 19_100.0 / 230.0);
        assert_eq!(evaluation.collision_free_rate, 0.5);
        let moving = Evaluation::new("empty", 1, 200, &episodes, Some(&[None; 4]));
        assert_eq!((moving.oracle_mean_steps, moving.optimality_ratio), (None, None));
    }
}
