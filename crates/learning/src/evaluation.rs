//! The evaluation of a policy.

use task::{
    Environment, Evaluation, EvaluationEpisode, Image,
    seeds::{Purpose, episode_scenario, episode_seed},
};

use super::{dyna_q::Decision, policy::Policy};

/// The episodes of an evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluationPlan {
    /// The scenario of every episode, or [`MIXED`](task::seeds::MIXED).
    pub scenario: String,
    /// Number of episodes.
    pub episodes: u32,
    /// The seed of the evaluation, which determines the seeds of its episodes.
    pub seed: u64,
    /// Maximum number of steps per episode.
    pub max_steps: u32,
}

impl EvaluationPlan {
    /// Summarizes the episodes of this plan with [`Evaluation::new`].
    ///
    /// `shortest_paths` holds the length of the full-knowledge shortest path of each episode, in
    /// steps.
    pub fn evaluation(
        &self,
        episodes: &[EvaluationEpisode],
        shortest_paths: Option<&[Option<u32>]>,
    ) -> Evaluation {
        Evaluation::new(&self.scenario, self.seed, self.max_steps, episodes, shortest_paths)
    }
}

/// Receives the progress of an evaluation. By default, its methods do nothing.
pub trait EvaluationListener {
    /// Called before each step with the indices of the episode and the step, both starting at 0,
    /// the current image and the decision.
    fn step(&mut self, _episode: u32, _step: u32, _image: &Image, _decision: &Decision) {}

    /// Called at the end of each episode.
    fn episode(&mut self, _episode: &EvaluationEpisode) {}
}

/// Runs the evaluation episodes of a plan and returns their results, one per episode.
///
/// The policy is greedy. An episode ends when the environment terminates or truncates it, or after
/// [`max_steps`](EvaluationPlan::max_steps) steps.
///
/// # Errors
///
/// Returns the first error from the environment.
///
/// # Examples
///
/// ```
/// # use std::{convert::Infallible, num::NonZeroU64};
/// use learning::{
///     evaluation::{EvaluationListener, EvaluationPlan, evaluate},
///     settings::Preset,
///     training::{Plan, Training},
/// };
/// # use task::{Action, Environment, Image, STEP_REWARD, Step};
/// #
/// # struct Corridor(Image);
/// #
/// # impl Environment for Corridor {
/// #     type Error = Infallible;
/// #     type PendingReset = ();
/// #     type PendingStep = Action;
/// #
/// #     fn begin_reset(&mut self, _: NonZeroU64, _: &str) -> Result<(), Infallible> {
/// #         Ok(())
/// #     }
/// #
/// #     fn finish_reset(&mut self, _: ()) -> Result<Image, Infallible> {
/// #         Ok(self.0.clone())
/// #     }
/// #
/// #     fn begin_step(&mut self, action: Action) -> Result<Action, Infallible> {
/// #         Ok(action)
/// #     }
/// #
/// #     fn finish_step(&mut self, action: Action) -> Result<Step, Infallible> {
/// #         let (image, terminated) = (self.0.clone(), action.turn_degrees() == 0);
/// #         let blocked = !terminated;
/// #         Ok(Step { image, reward: STEP_REWARD, terminated, truncated: false, blocked })
/// #     }
/// # }
/// #
/// # let mut corridor = Corridor(Image::try_from(vec![0u8; Image::BYTES])?);
///
/// struct Silent;
///
/// impl EvaluationListener for Silent {}
///
/// // An untrained network gives all actions the same value, so the policy always takes the first
/// // action, a turn, which the corridor blocks.
/// let plan = Plan { scenario: "corridor".into(), episodes: 1, seed: 1, rooms: 1 };
/// let mut policy = Training::new(plan, Preset::Paper.settings())?.policy();
///
/// let plan = EvaluationPlan { scenario: "corridor".into(), episodes: 2, seed: 1, max_steps: 20 };
/// let episodes = evaluate(&plan, &mut policy, &mut corridor, &mut Silent)?;
/// assert!(episodes.iter().all(|episode| episode.blocked == 20));
/// assert_eq!(plan.evaluation(&episodes, None).success_rate, 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn evaluate<E: Environment>(
    plan: &EvaluationPlan,
    policy: &mut Policy,
    environment: &mut E,
    listener: &mut impl EvaluationListener,
) -> Result<Vec<EvaluationEpisode>, E::Error> {
    let mut episodes = Vec::new();
    for episode in 0..plan.episodes {
        let seed = episode_seed(Purpose::Evaluation, plan.seed, episode);
        let scenario = episode_scenario(&plan.scenario, Purpose::Evaluation, plan.seed, episode);
        let mut image = environment.reset(seed, scenario)?;
        policy.begin(image.clone());
        let mut result = EvaluationEpisode { episode, steps: 0, blocked: 0, succeeded: false };
        while result.steps < plan.max_steps {
            let decision = policy.decide();
            listener.step(episode, result.steps, &image, &decision);
            let step = environment.step(decision.action)?;
            result.steps += 1;
            result.blocked += u32::from(step.blocked);
            result.succeeded = step.terminated;
            if step.terminated || step.truncated {
                break;
            }
            policy.observe(decision.action, step.image.clone());
            image = step.image;
        }
        listener.episode(&result);
        episodes.push(result);
    }
    Ok(episodes)
}
