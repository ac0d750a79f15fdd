//! Checks that a training run survives when its processes are stopped, frozen or traced, and then
//! continued.

use std::time::Duration;

use learning::{settings::Preset, training::Plan};

use crate::{Nodes, Outcome};

const TRAINING: Duration = Duration::from_secs(600);
const MAX_STEPS: u32 = 60;
const SEED: u64 = 5;

/// Trains, and meanwhile calls `interrupt` `count` times, alternately with the names `sim_node` and
/// `agent_node`. Asserts that the result matches that of an undisturbed training run.
///
/// `step_time` is the duration of a step in seconds; it must be long enough for the training to
/// outlast the interruptions.
///
/// # Panics
///
/// Panics if a node fails, or if the result differs.
pub fn assert_survives(
    mut nodes: Nodes,
    count: usize,
    step_time: f64,
    mut interrupt: impl FnMut(&mut Nodes, &str),
) {
    const EPISODES: u32 = 100;
    let out = nodes.path("run");
    let out_parameter = format!("out:='{}'", out.display());
    let (episodes, seed) = (format!("episodes:={EPISODES}"), format!("seed:={SEED}"));
    let step_time = format!("motion_time:={step_time:?}");
    nodes.start_simulator(&[&format!("max_steps:={MAX_STEPS}"), &step_time]);
    nodes.start_agent(
        "train",
        &[
            &out_parameter,
            &episodes,
            &seed,
            "preset:=paper",
            "scenario:=empty",
            "evaluation_episodes:=0",
        ],
    );
    for name in ["sim_node", "agent_node"].into_iter().cycle().take(count) {
        nodes.wait_for_steps(5);
        interrupt(&mut nodes, name);
    }
    assert!(nodes.ended("agent_node").is_none(), "the training ended before the last interruption");
    nodes.succeed("agent_node", TRAINING);
    assert!(nodes.ended("sim_node").is_none(), "{}", nodes.log("sim_node"));
    let plan = Plan { scenario: "empty".to_owned(), episodes: EPISODES, seed: SEED, rooms: 1 };
    let expected = Outcome::in_process(plan, Preset::Paper, MAX_STEPS, &nodes.path("here"));
    Outcome::read_from(&out).assert_identical(&expected);
}
