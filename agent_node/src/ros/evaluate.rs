//! `agent_node evaluate`.

use std::path::Path;

use learning::run::RunDirectory;
use log::info;
use ros_runtime::{Arguments, Node, parameters::Parameters};

use super::{
    common::{Common, CommonParameters, TestParameters},
    escapes,
    parameters::{TrainedModel, declare, scenario},
    policy_test::{PolicyTest, read_fewest_steps},
    simulator::Connection,
};

/// Tests a trained model over DDS and leaves `evaluation.json` in the directory `out`.
///
/// `oracle` is a file of the fewest possible steps of the test's episodes, if there is one.
///
/// # Errors
///
/// Arguments, parameters or files are wrong, or the simulator cannot be used.
pub fn evaluate(arguments: &Arguments, oracle: Option<&Path>) -> anyhow::Result<()> {
    let fewest = oracle.map(read_fewest_steps).transpose()?;
    let mut node = Node::new("agent_node", arguments, evac_msgs::DEFINITIONS)?;
    let model = TrainedModel::declare(node.parameters())?;
    let Options { scenario, test, out, common } = Options::declare(node.parameters(), &model)?;
    let common = Common::new(&mut node, common)?;
    node.start_services()?;

    let policy = model.policy()?;
    let directory = RunDirectory::open(Path::new(&out))?;
    let (connection, announcer) = Connection::new(&mut node, "")?;
    node.tell_ready();
    let Some(mut room) = common.connect(&node, connection)? else {
        return Ok(());
    };
    let plan = test.plan(&scenario);
    let mut test = PolicyTest { plan, policy, room: &mut room, announcer: &announcer };
    match test.run(fewest.as_ref())? {
        Some(tested) => {
            directory.write_json("evaluation.json", &tested.evaluation)?;
            escapes::draw(&mut test, "", &common, &directory)?;
        }
        None => info!("stopped before the end of the test"),
    }
    Ok(())
}

/// The parameters of a test, besides those of its model.
struct Options {
    scenario: String,
    test: TestParameters,
    out: String,
    common: CommonParameters,
}

impl Options {
    fn declare(parameters: &Parameters, model: &TrainedModel) -> anyhow::Result<Options> {
        let scenario = scenario(parameters, &model.defaults)?;
        let test = TestParameters::declare(parameters, "episodes", "seed", 1)?;
        let default_out = model.directory.display().to_string();
        let out = declare(parameters, "out", default_out, "the directory of evaluation.json")?;
        let common = CommonParameters::declare(parameters, "")?;
        Ok(Options { scenario, test, out, common })
    }
}

/// Declares what [`evaluate`] declares; the model may be missing.
pub(super) fn declare_parameters(parameters: &Parameters) -> anyhow::Result<()> {
    let model = TrainedModel::declare_optional(parameters)?;
    Options::declare(parameters, &model)?;
    Ok(())
}
