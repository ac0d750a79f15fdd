//! A training whose processes are interrupted: stopped, frozen or traced, and continued.

use std::time::Duration;

use learning::{settings::Preset, training::Plan};

use crate::{Nodes, Outcome};

const TRAINING: Duration = Duration::from_secs(600);
const MAX_STEPS: u32 = 60;
const SEED: u64 = 5;

/// Trains while simulator and agent are interrupted in turn, `count` times in all, by a function of the
/// nodes and the name of the one to interrupt. The result must be that of the undisturbed training.
///
/// `step_time`, in seconds, makes the training last until after the last interruption.
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
        &[&out_parameter, &episodes, &seed, "preset:=paper", "evaluation_episodes:=0"],
    );
    for name in ["sim_node", "agent_node"].into_iter().cycle().take(count) {
        nodes.wait_for_steps(5);
        interrupt(&mut nodes, name);
    }
    assert!(nodes.ended("agent_node").is_none(), "the training was over before the interruptions");
    nodes.succeed("agent_node", TRAINING);
    assert!(nodes.ended("sim_node").is_none(), "{}", nodes.log("sim_node"));
    let plan = Plan { scenario: "empty".to_owned(), episodes: EPISODES, seed: SEED, rooms: 1 };
    let expected = Outcome::in_process(plan, Preset::Paper, MAX_STEPS, &nodes.path("here"));
    Outcome::left_in(&out).assert_is(&expected);
}
