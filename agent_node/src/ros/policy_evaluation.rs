//! The evaluation of a policy over DDS: greedy episodes, their metrics and the images for the
//! report.

use std::{fs, path::Path};

use anyhow::Context;
use learning::{
    dyna_q::Decision,
    evaluation::{EvaluationListener, EvaluationPlan, evaluate},
    policy::Policy,
};
use log::{info, warn};
use report::CaptionedFrame;
use task::{Evaluation, EvaluationEpisode, Image, ShortestPaths};

use super::{
    announcer::Announcer, console::Console, simulator::Simulator, simulator_error::SimulatorError,
};

/// Number of camera images in the report: the first image of each of the first episodes.
const REPORT_FRAMES: usize = 8;

/// A policy and the environment in which it is evaluated.
pub(super) struct PolicyEvaluation<'a, 'node> {
    pub(super) plan: EvaluationPlan,
    pub(super) policy: Policy,
    pub(super) environment: &'a mut Simulator<'node>,
    pub(super) announcer: &'a Announcer,
}

/// The result of an evaluation.
pub(super) struct Evaluated {
    pub(super) evaluation: Evaluation,
    /// Images for the report.
    pub(super) frames: Vec<CaptionedFrame>,
}

/// Reads a file with the output of `sim_node oracle`.
pub(super) fn read_shortest_paths(path: &Path) -> anyhow::Result<ShortestPaths> {
    let context = || format!("--oracle {}", path.display());
    let text = fs::read_to_string(path).with_context(context)?;
    serde_json::from_str(&text).with_context(context)
}

impl PolicyEvaluation<'_, '_> {
    /// Runs all episodes of the plan. Returns `None` if the node shuts down before the last one
    /// ends.
    ///
    /// If `shortest` is for other episodes, it is ignored and a warning is logged.
    pub(super) fn run(
        &mut self,
        shortest: Option<&ShortestPaths>,
    ) -> anyhow::Result<Option<Evaluated>> {
        let plan = &self.plan;
        let mut listener = ConsoleListener {
            console: Console::new("evaluation", plan.episodes, 0),
            announcer: self.announcer,
            episodes: plan.episodes,
            succeeded: 0,
            frames: Vec::new(),
        };
        let episodes = match evaluate(plan, &mut self.policy, self.environment, &mut listener) {
            Ok(episodes) => episodes,
            Err(SimulatorError::Shutdown) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let matching = shortest
            .filter(|paths| paths.matches_evaluation(&plan.scenario, plan.seed, plan.episodes));
        if shortest.is_some() && matching.is_none() {
            warn!("ignored --oracle: its scenario or seeds differ from those of the evaluation");
        }
        let evaluation = plan.evaluation(&episodes, matching.map(|paths| paths.steps.as_slice()));
        let (successes, rate) = (evaluation.successes, 100.0 * evaluation.success_rate);
        info!("{successes} of {} evaluation episodes succeeded: {rate:.1} %", evaluation.episodes);
        Ok(Some(Evaluated { evaluation, frames: listener.frames }))
    }
}

/// Reports the progress of an evaluation and collects the images for the report.
struct ConsoleListener<'a> {
    console: Console,
    announcer: &'a Announcer,
    episodes: u32,
    succeeded: u32,
    frames: Vec<CaptionedFrame>,
}

impl EvaluationListener for ConsoleListener<'_> {
    fn step(&mut self, episode: u32, step: u32, image: &Image, decision: &Decision) {
        self.announcer.announce(decision);
        if step == 0 && self.frames.len() < REPORT_FRAMES {
            let action = match decision.action.turn_degrees() {
                0 => "straight ahead".to_owned(),
                turn if turn > 0 => format!("{turn}\u{b0} to the left"),
                turn => format!("{}\u{b0} to the right", -turn),
            };
            let caption = format!("Evaluation episode {episode}; first action: {action}");
            self.frames.push(CaptionedFrame { image: image.clone(), caption });
        }
    }

    fn episode(&mut self, result: &EvaluationEpisode) {
        self.succeeded += u32::from(result.succeeded);
        self.console.evaluation_episode(result.episode + 1, self.episodes, self.succeeded, result);
    }
}
