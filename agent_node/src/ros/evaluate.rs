//! `agent_node evaluate`: evaluates a trained model over DDS.

use std::path::Path;

use learning::run::RunDirectory;
use log::info;
use ros_runtime::{Arguments, Node, parameters::Parameters};

use super::{
    common::{Common, CommonParameters, EvaluationParameters},
    escapes,
    parameters::{TrainedModel, declare, scenario},
    policy_evaluation::{PolicyEvaluation, read_shortest_paths},
    robustness,
    simulator::Connection,
};

/// Evaluates a trained model over DDS. Writes `evaluation.json` and the figures to the directory
/// given by the parameter `out`. With the parameter `robustness`, also evaluates it under each
/// perturbation of the simulator.
///
/// `oracle` is a file with the output of `sim_node oracle` for the evaluation episodes: the lengths
/// of the full-knowledge shortest paths, which are the baseline for `optimality_ratio`.
///
/// # Errors
///
/// Returns an error if arguments, parameters or files are invalid, if a file cannot be written, or
/// if the environment fails.
pub fn evaluate(arguments: &Arguments, oracle: Option<&Path>) -> anyhow::Result<()> {
    let shortest = oracle.map(read_shortest_paths).transpose()?;
    let mut node = Node::new("agent_node", arguments, evac_msgs::DEFINITIONS)?;
    let model = TrainedModel::declare(node.parameters())?;
    let options = Options::declare(node.parameters(), &model)?;
    let Options { scenario, evaluation, out, robustness, common } = options;
    let common = Common::new(&mut node, common)?;
    node.start_services()?;

    let policy = model.policy()?;
    let directory = RunDirectory::open(Path::new(&out))?;
    let (connection, announcer) = Connection::new(&mut node, "")?;
    node.notify_ready();
    let Some(mut environment) = common.connect(&node, connection)? else {
        return Ok(());
    };
    let plan = evaluation.plan(&scenario);
    let mut evaluation =
        PolicyEvaluation { plan, policy, environment: &mut environment, announcer: &announcer };
    match evaluation.run(shortest.as_ref())? {
        Some(evaluated) => {
            directory.write_json("evaluation.json", &evaluated.evaluation)?;
            escapes::draw(&mut evaluation, "", &common, &directory)?;
            let simulator = &common.simulator_parameters;
            if robustness
                && !robustness::evaluate(&mut evaluation, shortest.as_ref(), simulator, &directory)?
            {
                info!("evaluation interrupted; robustness.json was not written");
                return Ok(());
            }
            info!("results written to {out}");
        }
        None => info!("evaluation interrupted; evaluation.json was not written"),
    }
    Ok(())
}

/// The parameters of `evaluate`, in addition to those of the model.
struct Options {
    scenario: String,
    evaluation: EvaluationParameters,
    out: String,
    robustness: bool,
    common: CommonParameters,
}

impl Options {
    fn declare(parameters: &Parameters, model: &TrainedModel) -> anyhow::Result<Options> {
        let scenario = scenario(parameters, &model.defaults)?;
        let evaluation = EvaluationParameters::declare(parameters, "episodes", "seed", 1)?;
        let default_out = model.directory.display().to_string();
        let description = "directory for evaluation.json and figures (default: the model \
                           directory)";
        let out = declare(parameters, "out", default_out, description)?;
        let robustness = declare(
            parameters,
            "robustness",
            false,
            "also evaluate the policy under each of the simulator's perturbations individually and \
             under all of them combined, at the levels mild and strong, and write robustness.json, \
             robustness.csv and robustness.html; changes the simulator's parameters and restores \
             them afterwards, unless interrupted",
        )?;
        let common = CommonParameters::declare(parameters, "")?;
        Ok(Options { scenario, evaluation, out, robustness, common })
    }
}

/// Declares the parameters of [`evaluate`]; `model` may be empty.
pub(super) fn declare_parameters(parameters: &Parameters) -> anyhow::Result<()> {
    let model = TrainedModel::declare_optional(parameters)?;
    Options::declare(parameters, &model)?;
    Ok(())
}
