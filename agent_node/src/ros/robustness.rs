//! The robustness of a policy: its evaluation under each perturbation that the simulator offers.

use std::{collections::BTreeMap, time::Duration};

use anyhow::{Context, anyhow, bail};
use learning::run::RunDirectory;
use log::{info, warn};
use report::RobustnessReport;
use ros_runtime::{
    Node,
    parameters::{ParameterClient, ParameterValue},
};
use task::{
    Evaluation, RobustnessRow, ShortestPaths,
    robustness::{ALL, CLEAN},
};

use super::policy_evaluation::PolicyEvaluation;

/// Timeout for each call to the simulator's parameter services.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Maximum number of attempts at an evaluation.
const MAX_ATTEMPTS: u32 = 5;

/// The simulator's parameter that sets all perturbations.
const RANDOMIZATION: &str = "randomization";
/// Its values.
const NONE: &str = "none";
const LEVELS: [&str; 2] = ["mild", "strong"];

/// The perturbations, each with the simulator's parameters that switch it on. Latency and odometry
/// do not affect an evaluation, because each image is the response to a step.
const PERTURBATIONS: [&[&str]; 13] = [
    &["camera.noise"],
    &["camera.gain_range"],
    &["camera.color_range"],
    &["camera.pitch_range", "camera.roll_range", "camera.yaw_range"],
    &["camera.height_range", "camera.lens_range"],
    &["camera.latency"],
    &["camera.drop_rate"],
    &["light.direction_range", "surface.color_range"],
    &["motion.turn_noise", "motion.step_noise"],
    &["motion.turn_bias", "motion.step_bias"],
    &["motion.blocked"],
    &["odom.noise", "odom.drift"],
    &["obstacles.speed_range"],
];

type Values = BTreeMap<String, ParameterValue>;

/// Evaluates a policy without perturbations, under each perturbation alone and under all together.
/// Writes `robustness.json`, `robustness.csv`, `robustness.html` and `figures/robustness.svg`.
/// Returns `false` if the node shuts down before the last evaluation ends.
///
/// # Errors
///
/// Returns an error if the simulator's parameters cannot be read or set, if the environment fails,
/// or if a file cannot be written.
pub(super) fn evaluate(
    evaluation: &mut PolicyEvaluation,
    shortest: Option<&ShortestPaths>,
    simulator: &ParameterClient,
    directory: &RunDirectory,
) -> anyhow::Result<bool> {
    let node = evaluation.environment.node();
    let simulator = Simulator { node, parameters: simulator };
    let before = simulator.values()?;
    let rows = measure(evaluation, shortest, &simulator);
    // Restored even after an error, because the simulator may have other clients. After a shutdown
    // of this node, it no longer can be.
    let names = PERTURBATIONS.iter().copied().flatten().chain([&RANDOMIZATION]);
    let changes = names.filter_map(|name| Some((*name, before.get(*name)?.clone())));
    let restored = simulator.set(changes.collect());
    let Some(rows) = rows? else { return Ok(false) };
    if let Err(error) = restored {
        warn!("cannot restore the perturbations of the simulator: {error:#}");
    }
    directory.write_json("robustness.json", &rows)?;
    directory.write_csv("robustness.csv", &rows)?;
    let report = RobustnessReport { scenario: &evaluation.plan.scenario, rows: &rows };
    directory.write("robustness.html", report.to_html()?.as_bytes())?;
    let figures = RunDirectory::open(&directory.file("figures"))?;
    figures.write("robustness.svg", report.figure().as_bytes())?;
    Ok(true)
}

/// Returns the rows of the table, or `None` after a shutdown.
fn measure(
    evaluation: &mut PolicyEvaluation,
    shortest: Option<&ShortestPaths>,
    simulator: &Simulator,
) -> anyhow::Result<Option<Vec<RobustnessRow>>> {
    let level = |name: &str| (RANDOMIZATION, ParameterValue::String(name.to_owned()));
    let mut values = Vec::new();
    for name in LEVELS {
        simulator.set(vec![level(name)])?;
        values.push((name, simulator.values()?));
    }
    let mut worlds = vec![(CLEAN.to_owned(), NONE, vec![level(NONE)])];
    for parameters in PERTURBATIONS {
        for (name, values) in &values {
            let value = |parameter: &&'static str| {
                let value = values.get(*parameter);
                Ok((*parameter, value.with_context(|| missing(parameter))?.clone()))
            };
            let alone: anyhow::Result<Vec<_>> = parameters.iter().map(value).collect();
            let changes = [vec![level(NONE)], alone?].concat();
            worlds.push((parameters.join(", "), name, changes));
        }
    }
    worlds.extend(LEVELS.map(|name| (ALL.to_owned(), name, vec![level(name)])));

    let count = worlds.len();
    let mut rows = Vec::new();
    for (index, (perturbation, level, changes)) in worlds.into_iter().enumerate() {
        info!("robustness, evaluation {} of {count}: {perturbation}, {level}", index + 1);
        let Some(result) = evaluate_in(evaluation, shortest, simulator, &changes)? else {
            return Ok(None);
        };
        rows.push(RobustnessRow::new(&perturbation, level, &result));
    }
    Ok(Some(rows))
}

/// Evaluates the policy with these parameters of the simulator. Repeats the evaluation if the
/// simulator was restarted in the meantime, because it then has its parameters of the start.
fn evaluate_in(
    evaluation: &mut PolicyEvaluation,
    shortest: Option<&ShortestPaths>,
    simulator: &Simulator,
    changes: &[(&str, ParameterValue)],
) -> anyhow::Result<Option<Evaluation>> {
    for _ in 0..MAX_ATTEMPTS {
        simulator.set(changes.to_vec())?;
        let expected = simulator.values()?;
        let result = evaluation.run(shortest);
        if let Ok(None) = result {
            return Ok(None);
        }
        if simulator.values()? == expected {
            return Ok(result?.map(|evaluated| evaluated.evaluation));
        }
        warn!("the parameters of the simulator changed: repeating the evaluation");
    }
    bail!("the parameters of the simulator changed in each of {MAX_ATTEMPTS} evaluations")
}

/// The parameter services of the simulator.
struct Simulator<'a> {
    node: &'a Node,
    parameters: &'a ParameterClient,
}

impl Simulator<'_> {
    fn values(&self) -> anyhow::Result<Values> {
        let values = self.node.block_on(self.parameters.values(TIMEOUT));
        let values = values.context("cannot read the parameters of the simulator")?;
        values.contains_key(RANDOMIZATION).then_some(values).with_context(|| missing(RANDOMIZATION))
    }

    fn set(&self, changes: Vec<(&str, ParameterValue)>) -> anyhow::Result<()> {
        let result = self.node.block_on(self.parameters.set_all(changes, TIMEOUT));
        let result = result.context("cannot set the parameters of the simulator")?;
        result.map_err(|reason| anyhow!("the simulator refuses a perturbation: {reason}"))
    }
}

fn missing(parameter: &str) -> String {
    format!("the simulator has no parameter '{parameter}' (expected: a sim_node)")
}
