//! The greedy test of a policy over DDS, its measures and its pictures.

use std::{fs, path::Path};

use anyhow::Context;
use learning::{
    dyna_q::Decision,
    evaluation::{TestListener, TestPlan, run_test},
    policy::Policy,
};
use log::{info, warn};
use report::CaptionedFrame;
use task::{Evaluation, FewestSteps, Image, TestEpisode};

use super::{
    announcer::Announcer, console::Console, simulator::Simulator, simulator_error::SimulatorError,
};

/// Images that the report shows.
const REPORT_FRAMES: usize = 8;

/// A policy and the room that it is tested in.
pub(super) struct PolicyTest<'a, 'node> {
    pub(super) plan: TestPlan,
    pub(super) policy: Policy,
    pub(super) room: &'a mut Simulator<'node>,
    pub(super) announcer: &'a Announcer,
}

/// What a test leaves.
pub(super) struct Tested {
    pub(super) evaluation: Evaluation,
    pub(super) frames: Vec<CaptionedFrame>,
}

/// Reads what `sim_node oracle` printed.
pub(super) fn read_fewest_steps(path: &Path) -> anyhow::Result<FewestSteps> {
    let context = || format!("--oracle {}", path.display());
    let text = fs::read_to_string(path).with_context(context)?;
    serde_json::from_str(&text).with_context(context)
}

impl PolicyTest<'_, '_> {
    /// Runs the test; `None` if the node shut down before its end.
    pub(super) fn run(&mut self, fewest: Option<&FewestSteps>) -> anyhow::Result<Option<Tested>> {
        let plan = &self.plan;
        let mut listener = ConsoleTestListener {
            console: Console::new("test", plan.episodes, 0),
            announcer: self.announcer,
            episodes: plan.episodes,
            escaped: 0,
            frames: Vec::new(),
        };
        let episodes = match run_test(plan, &mut self.policy, self.room, &mut listener) {
            Ok(episodes) => episodes,
            Err(SimulatorError::Shutdown) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let fitting =
            fewest.filter(|fewest| fewest.is_of_test(&plan.scenario, plan.seed, plan.episodes));
        if fewest.is_some() && fitting.is_none() {
            warn!(
                "--oracle is of another scenario or of other seeds than the test: it is left out"
            );
        }
        let evaluation = plan.evaluation(&episodes, fitting.map(|fewest| fewest.steps.as_slice()));
        let (successes, rate) = (evaluation.successes, 100.0 * evaluation.success_rate);
        info!("{successes} of {} test episodes escaped: {rate:.1} %", evaluation.episodes);
        Ok(Some(Tested { evaluation, frames: listener.frames }))
    }
}

struct ConsoleTestListener<'a> {
    console: Console,
    announcer: &'a Announcer,
    episodes: u32,
    escaped: u32,
    frames: Vec<CaptionedFrame>,
}

impl TestListener for ConsoleTestListener<'_> {
    fn step(&mut self, episode: u32, step: u32, image: &Image, decision: &Decision) {
        self.announcer.announce(decision);
        // The first image of some episodes, and where the robot goes from there.
        if step == 0 && self.frames.len() < REPORT_FRAMES {
            let turn = decision.action.turn_degrees();
            let caption = format!("Test episode {episode}: the policy turns {turn:+}\u{b0}");
            self.frames.push(CaptionedFrame { image: image.clone(), caption });
        }
    }

    fn episode(&mut self, result: &TestEpisode) {
        self.escaped += u32::from(result.escaped);
        self.console.test_episode(result.episode + 1, self.episodes, self.escaped, result);
    }
}
