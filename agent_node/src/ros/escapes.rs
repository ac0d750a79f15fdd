//! Records escapes for the figures: episodes with the ground truth at each step.
//!
//! The figures show the first evaluation episodes, and three episodes in a fixed room, which is set
//! up through the simulator's `fixed_*` parameters.

use std::{num::NonZeroU64, time::Duration};

use learning::run::RunDirectory;
use log::warn;
use report::{
    EscapeFigures,
    escape::{Escape, Moment},
};
use ros_runtime::parameters::{ParameterClient, ParameterValue};
use task::{
    Environment, Image, Scenario,
    seeds::{Purpose, episode_scenario, episode_seed},
};

use super::{common::Common, ground_truth::GroundTruth, policy_evaluation::PolicyEvaluation};

/// Number of evaluation episodes in the figures, starting with the first.
const EPISODES: u32 = 6;
/// Step limit of an episode in the figures.
const MAX_STEPS: u32 = 200;
/// Maximum number of resets at the start of an episode. The reset is repeated because no ground
/// truth arrives until discovery has matched the subscriptions.
const MAX_ATTEMPTS: usize = 5;
/// Timeout for a call to the simulator's parameter services.
const TIMEOUT: Duration = Duration::from_secs(5);

/// A fixed room: the values of the simulator's `fixed_*` parameters.
struct FixedRoom {
    /// `fixed_exit`: the wall and the offset along it, in metres.
    exit: [f64; 2],
    /// `fixed_cylinders`: x and y of each centre, in metres.
    cylinders: &'static [f64],
    /// `fixed_robot` for each episode: x and y in metres, yaw in radians.
    starts: [[f64; 3]; 3],
}

impl FixedRoom {
    /// Returns the fixed room for a scenario.
    fn of(scenario: Scenario) -> FixedRoom {
        let around = [[-0.8, -0.8, 0.0], [0.9, -0.7, 2.4], [-1.0, 0.1, -1.6]];
        let room = FixedRoom { exit: [1.0, 0.5], cylinders: &[], starts: around };
        match scenario {
            Scenario::Empty => room,
            // As in Figure 7 of the paper: the robot starts inside the concave wall, and the exit
            // is behind the wall.
            Scenario::Concave => FixedRoom {
                exit: [1.0, 0.0],
                starts: [[0.0, -0.05, -1.0], [-0.3, -0.2, 2.0], [0.25, -0.2, 0.5]],
                ..room
            },
            Scenario::OneCylinder | Scenario::OneMoving => {
                FixedRoom { cylinders: &[0.1, 0.1], ..room }
            }
            Scenario::TwoCylinders | Scenario::TwoMoving => {
                FixedRoom { cylinders: &[-0.35, 0.25, 0.4, -0.1], ..room }
            }
            Scenario::ThreeCylinders | Scenario::ThreeMoving => {
                FixedRoom { cylinders: &[-0.45, 0.3, 0.45, 0.35, 0.0, -0.45], ..room }
            }
        }
    }
}

/// Records escapes, draws them and saves the figures in the directory `figures`. `namespace` is the
/// simulator's namespace, relative to that of the node.
///
/// Returns `None` if the parameter `figures` is false, if there is no ground truth, or after an
/// environment error, including a shutdown: the evaluation is valid without figures.
///
/// # Errors
///
/// Returns an error if a subscription cannot be created or a file cannot be written.
pub(super) fn draw(
    evaluation: &mut PolicyEvaluation,
    namespace: &str,
    common: &Common,
    directory: &RunDirectory,
) -> anyhow::Result<Option<EscapeFigures>> {
    if !common.figures {
        return Ok(None);
    }
    let truth = GroundTruth::new(evaluation.environment.node(), namespace)?;
    let figures = match figures(evaluation, &truth, &common.simulator_parameters) {
        Ok(Some(figures)) => figures,
        Ok(None) => return Ok(None),
        Err(error) => {
            warn!("cannot draw the escapes: {error:#}");
            return Ok(None);
        }
    };
    let directory = RunDirectory::open(&directory.file("figures"))?;
    figures.files().try_for_each(|(name, bytes)| directory.write(&name, bytes))?;
    Ok(Some(figures))
}

/// Records the escapes of a policy and draws them. Returns `None` and logs a warning if there is no
/// ground truth.
fn figures<'node>(
    evaluation: &mut PolicyEvaluation<'_, 'node>,
    truth: &GroundTruth<'node>,
    parameters: &ParameterClient,
) -> anyhow::Result<Option<EscapeFigures>> {
    let plan = evaluation.plan.clone();
    let mut recorder = Recorder { evaluation, truth };
    let mut escapes = Vec::new();
    for episode in 0..plan.episodes.min(EPISODES) {
        let seed = episode_seed(Purpose::Evaluation, plan.seed, episode);
        let scenario = episode_scenario(&plan.scenario, Purpose::Evaluation, plan.seed, episode);
        let Some(escape) = recorder.record(seed, scenario)? else {
            warn!("cannot draw the escapes: no messages on tf or scene for an image");
            return Ok(None);
        };
        escapes.push(escape);
    }
    // `None` for `mixed`; its fixed room is the one with the concave wall.
    let scenario = plan.scenario.parse::<Scenario>().ok();
    let fixed = recorder.fixed(scenario.unwrap_or(Scenario::Concave), parameters)?;
    let moving = scenario.is_some_and(Scenario::has_moving_obstacles);
    Ok(Some(EscapeFigures::draw(&escapes, &fixed, moving)))
}

/// Runs episodes and records each step with its ground truth.
struct Recorder<'a, 'b, 'node> {
    evaluation: &'a mut PolicyEvaluation<'b, 'node>,
    truth: &'a GroundTruth<'node>,
}

impl Recorder<'_, '_, '_> {
    /// Records three escapes from the fixed room for a scenario. Returns fewer if there is no
    /// ground truth or, with a logged warning, if a simulator parameter cannot be read or set.
    fn fixed(
        &mut self,
        scenario: Scenario,
        simulator: &ParameterClient,
    ) -> anyhow::Result<Vec<Escape>> {
        let node = self.evaluation.environment.node();
        let previous = match node.block_on(simulator.values(TIMEOUT)) {
            Ok(values) => values,
            Err(error) => {
                warn!("cannot read the simulator parameters for the figures: {error}");
                return Ok(Vec::new());
            }
        };
        let set = |name: &str, value: ParameterValue| {
            let result = node.block_on(simulator.set(name, value, TIMEOUT));
            let failure = result.map_or_else(|error| Some(error.to_string()), Result::err);
            if let Some(reason) = &failure {
                warn!("cannot set the simulator parameter {name} for the figures: {reason}");
            }
            failure.is_none()
        };
        let escapes = self.record_starts(scenario, set);
        // Restore the parameters even after an error, because the simulator may have other clients.
        for name in ["fixed_exit", "fixed_cylinders", "fixed_robot"] {
            let value = previous.get(name).cloned();
            set(name, value.unwrap_or(ParameterValue::DoubleArray(Vec::new())));
        }
        escapes
    }

    /// Records an escape from each start pose in the [`FixedRoom`]. `set` sets a simulator
    /// parameter and returns whether it succeeded; a failure ends the recording.
    fn record_starts(
        &mut self,
        scenario: Scenario,
        set: impl Fn(&str, ParameterValue) -> bool,
    ) -> anyhow::Result<Vec<Escape>> {
        let FixedRoom { exit, cylinders, starts } = FixedRoom::of(scenario);
        let set = |name, numbers: &[f64]| set(name, ParameterValue::DoubleArray(numbers.to_vec()));
        let mut escapes = Vec::new();
        if !(set("fixed_exit", &exit) && set("fixed_cylinders", cylinders)) {
            return Ok(escapes);
        }
        for (start, episode) in starts.iter().zip(0..) {
            if !set("fixed_robot", start) {
                break;
            }
            let seed = episode_seed(Purpose::Evaluation, self.evaluation.plan.seed, episode);
            escapes.extend(self.record(seed, scenario.name())?);
        }
        Ok(escapes)
    }

    /// Records one episode. Returns `None` if there is no ground truth.
    fn record(&mut self, seed: NonZeroU64, scenario: &str) -> anyhow::Result<Option<Escape>> {
        let PolicyEvaluation { plan, policy, environment, announcer } = &mut *self.evaluation;
        let mut first: Option<(Image, _)> = None;
        for _ in 0..MAX_ATTEMPTS {
            let image = environment.reset(seed, scenario)?;
            let stamp = environment.stamp();
            if let Some(truth) = self.truth.pose_at(stamp).zip(self.truth.scene_at(stamp)) {
                first = Some((image, truth));
                break;
            }
        }
        let Some((mut image, (mut pose, mut scene))) = first else {
            return Ok(None);
        };
        policy.begin(image.clone());
        let parsed = scenario.parse::<Scenario>();
        let is_static = parsed.is_ok_and(|scenario| !scenario.has_moving_obstacles());
        let (mut moments, mut escaped) = (Vec::new(), false);
        for _ in 0..plan.max_steps.min(MAX_STEPS) {
            let decision = policy.decide();
            announcer.announce(&decision);
            let step = environment.step(decision.action)?;
            let stamp = environment.stamp();
            let next_scene = match is_static {
                true => Some(scene.clone()),
                false => self.truth.scene_at(stamp),
            };
            let Some((next_pose, next_scene)) = self.truth.pose_at(stamp).zip(next_scene) else {
                return Ok(None);
            };
            let (values, action, blocked) = (decision.values, decision.action, step.blocked);
            moments.push(Moment { pose, scene, image, values, action, blocked });
            (pose, scene, image) = (next_pose, next_scene, step.image.clone());
            policy.observe(action, step.image);
            escaped = step.terminated;
            if step.terminated || step.truncated {
                break;
            }
        }
        Ok(Some(Escape { moments, last: (pose, scene), escaped }))
    }
}
