//! How good a policy is: what a test measures, the same wherever it is run.

use serde::{Deserialize, Serialize};

/// What happened in one episode of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct TestEpisode {
    /// Counts from 0.
    pub episode: u32,
    /// Actions taken, blocked ones included.
    pub steps: u32,
    /// How many of them were blocked.
    pub blocked: u32,
    /// Whether the exit was reached.
    pub escaped: bool,
}

/// The result of a test: `evaluation.json`, and the field `evaluation` of `summary.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// The scenario that was tested.
    pub scenario: String,
    /// How many episodes were run.
    pub episodes: u32,
    /// How many of them ended at the exit within `max_steps`.
    pub successes: u32,
    /// `successes / episodes`.
    pub success_rate: f64,
    /// The most steps an episode may take before it counts as a failure.
    pub max_steps: u32,
    /// The run seed of the test; its episodes' seeds are never those of a training.
    pub seed: u64,
    /// Mean steps of the successful episodes; null if there is none.
    pub mean_steps: Option<f64>,
    /// Mean of the fewest possible steps over all the episodes, with full knowledge of the room;
    /// null where obstacles move, or where nobody computed it.
    pub oracle_mean_steps: Option<f64>,
    /// Steps of the successful episodes over the fewest possible steps of the same episodes.
    pub optimality_ratio: Option<f64>,
    /// Blocked moves per 100 steps, failures included.
    pub blocked_per_100_steps: f64,
    /// Share of the episodes without a single blocked move.
    pub collision_free_rate: f64,
}

impl Evaluation {
    /// Sums up a test. `fewest_steps` is the fewest possible number for each episode, if somebody
    /// with the room's plan has computed it; one that is missing leaves the ratio open.
    pub fn new(
        scenario: &str,
        seed: u64,
        max_steps: u32,
        episodes: &[TestEpisode],
        fewest_steps: Option<&[Option<u32>]>,
    ) -> Evaluation {
        let count = episodes.len() as f64;
        let share = |number: usize| {
            if episodes.is_empty() { 0.0 } else { number as f64 / count }
        };
        let escaped: Vec<&TestEpisode> = episodes.iter().filter(|e| e.escaped).collect();
        let steps: u64 = episodes.iter().map(|e| u64::from(e.steps)).sum();
        let blocked: u64 = episodes.iter().map(|e| u64::from(e.blocked)).sum();
        let escape_steps: u64 = escaped.iter().map(|e| u64::from(e.steps)).sum();
        // One number for each episode, or none at all.
        let fewest: Option<Vec<u64>> = fewest_steps
            .filter(|fewest| fewest.len() == episodes.len() && !fewest.is_empty())
            .and_then(|fewest| fewest.iter().map(|steps| steps.map(u64::from)).collect());
        let fewest_of_escapes: Option<u64> =
            fewest.as_ref().map(|all| escaped.iter().map(|e| all[e.episode as usize]).sum());
        Evaluation {
            scenario: scenario.to_owned(),
            episodes: episodes.len() as u32,
            successes: escaped.len() as u32,
            success_rate: share(escaped.len()),
            max_steps,
            seed,
            mean_steps: ratio(escape_steps, escaped.len() as u64),
            oracle_mean_steps: fewest.and_then(|all| ratio(all.iter().sum(), all.len() as u64)),
            optimality_ratio: fewest_of_escapes.and_then(|fewest| ratio(escape_steps, fewest)),
            blocked_per_100_steps: ratio(100 * blocked, steps).unwrap_or(0.0),
            collision_free_rate: share(episodes.iter().filter(|e| e.blocked == 0).count()),
        }
    }
}

fn ratio(numerator: u64, denominator: u64) -> Option<f64> {
    (denominator > 0).then(|| numerator as f64 / denominator as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_is_summed_up() {
        let episode =
            |episode, steps, blocked, escaped| TestEpisode { episode, steps, blocked, escaped };
        let episodes = [
            episode(0, 10, 0, true),
            episode(1, 200, 190, false),
            episode(2, 14, 1, true),
            episode(3, 6, 0, true),
        ];
        let fewest = [Some(8), Some(9), Some(12), Some(5)];
        let evaluation = Evaluation::new("empty", 1, 200, &episodes, Some(&fewest));
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
