//! The greedy test of a trained policy.

use task::{
    Environment, Evaluation, Image, TestEpisode,
    seeds::{Purpose, episode_scenario, episode_seed},
};

use super::{dyna_q::Decision, policy::Policy};

/// What a test is of.
#[derive(Clone, Debug, PartialEq)]
pub struct TestPlan {
    /// The scenario of every reset, or [`MIXED`](task::seeds::MIXED).
    pub scenario: String,
    /// How many episodes.
    pub episodes: u32,
    /// The seed of the test; with another one the rooms are others.
    pub seed: u64,
    /// How many steps an episode may take.
    pub max_steps: u32,
}

impl TestPlan {
    /// Sums up a test of this plan, as [`Evaluation::new`] does.
    pub fn evaluation(
        &self,
        episodes: &[TestEpisode],
        fewest_steps: Option<&[Option<u32>]>,
    ) -> Evaluation {
        Evaluation::new(&self.scenario, self.seed, self.max_steps, episodes, fewest_steps)
    }
}

/// Who wants to know how a test goes.
pub trait TestListener {
    /// The agent sees an image, and has decided.
    fn step(&mut self, _episode: u32, _step: u32, _image: &Image, _decision: &Decision) {}

    /// An episode has ended.
    fn episode(&mut self, _episode: &TestEpisode) {}
}

/// Runs a test: always the action of the greatest value, no exploration.
///
/// # Errors
///
/// The room fails.
pub fn run_test<E: Environment>(
    plan: &TestPlan,
    policy: &mut Policy,
    room: &mut E,
    listener: &mut impl TestListener,
) -> Result<Vec<TestEpisode>, E::Error> {
    let mut episodes = Vec::new();
    for episode in 0..plan.episodes {
        let seed = episode_seed(Purpose::Test, plan.seed, episode);
        let scenario = episode_scenario(&plan.scenario, Purpose::Test, plan.seed, episode);
        let mut image = room.reset(seed, scenario)?;
        policy.begin(image.clone());
        let mut result = TestEpisode { episode, steps: 0, blocked: 0, escaped: false };
        while result.steps < plan.max_steps {
            let decision = policy.decide();
            listener.step(episode, result.steps, &image, &decision);
            let step = room.step(decision.action)?;
            result.steps += 1;
            result.blocked += u32::from(step.blocked);
            result.escaped = step.terminated;
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
