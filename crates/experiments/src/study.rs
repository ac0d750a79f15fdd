//! Training runs and evaluations in this process, as the reproduction and the ablation perform them.

use learning::{
    evaluation::{EvaluationPlan, evaluate},
    policy::Policy,
    settings::Settings,
    training::{Plan, Training},
};
use sim_node::{
    reality::{Randomization, Reality},
    world::WorldSettings,
};
use task::{Evaluation, Scenario};

use crate::{NullListener, Room};

/// Number of episodes in each evaluation.
pub const EVALUATION_EPISODES: u32 = 2000;
/// The default seed of `evaluate.sh`.
pub const EVALUATION_SEED: u64 = 1;
/// The default step limit of `evaluate.sh`.
const EVALUATION_STEPS: u32 = 200;

fn room(level: Randomization) -> Room {
    Room::new(WorldSettings { reality: Reality::of(level), ..WorldSettings::default() })
}

/// Trains in a room with perturbations of this level.
///
/// # Errors
///
/// Returns an error if the settings do not describe a valid network or training diverges.
pub fn train(plan: Plan, settings: Settings, level: Randomization) -> anyhow::Result<Training> {
    let mut training = Training::new(plan, settings)?;
    training.run(&mut [room(level)], &mut NullListener)?;
    Ok(training)
}

/// Evaluates a policy in a scenario with perturbations of this level. `shortest_paths` holds the
/// lengths of the shortest paths of the episodes, if the optimality ratio is needed.
///
/// # Errors
///
/// Returns an error if the room fails.
pub fn evaluate_policy(
    policy: &mut Policy,
    scenario: Scenario,
    level: Randomization,
    shortest_paths: Option<&[Option<u32>]>,
) -> anyhow::Result<Evaluation> {
    let plan = EvaluationPlan {
        scenario: scenario.name().to_owned(),
        episodes: EVALUATION_EPISODES,
        seed: EVALUATION_SEED,
        max_steps: EVALUATION_STEPS,
    };
    let episodes = evaluate(&plan, policy, &mut room(level), &mut NullListener)?;
    Ok(plan.evaluation(&episodes, shortest_paths))
}
