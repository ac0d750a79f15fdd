//! What `train` and `evaluate` have in common: parameters, and the way to a simulator.

use std::{collections::BTreeMap, time::Duration};

use learning::evaluation::TestPlan;
use log::warn;
use ros_runtime::{
    Node,
    parameters::{Descriptor, ParameterClient, ParameterValue, Parameters},
};

use super::{
    name_in,
    parameters::{count, declare},
    simulator::{Connection, Simulator},
    simulator_error::SimulatorError,
};

/// The largest seed: parameters are signed in ROS.
pub(super) const LARGEST_SEED: u64 = (1 << 53) - 1;
/// How long to wait for the simulator's parameters, which are only for the record.
const PARAMETER_DEADLINE: Duration = Duration::from_secs(10);

/// The parameters that `train` and `evaluate` have in common.
pub(super) struct CommonParameters {
    deadline: Option<Duration>,
    simulator: String,
    figures: bool,
}

/// What `train` and `evaluate` have in common.
pub(super) struct Common {
    pub(super) deadline: Option<Duration>,
    pub(super) simulator_parameters: ParameterClient,
    simulator: String,
    pub(super) figures: bool,
}

impl CommonParameters {
    /// Declares them, the last ones of a command. `namespace` is that of the simulator whose parameters
    /// are recorded.
    pub(super) fn declare(
        parameters: &Parameters,
        namespace: &str,
    ) -> anyhow::Result<CommonParameters> {
        let deadline = parameters.declare(
            "simulator_timeout",
            120.0,
            Descriptor::read_only("timeout of a call to the simulator, in seconds; 0: none")
                .range(0.0..=1e6),
        )?;
        let default = name_in(namespace, "sim_node");
        let simulator = declare(parameters, "simulator", default, "the simulator's node")?;
        let figures = declare(parameters, "figures", true, "draw some escapes after the test")?;
        parameters.refuse_undeclared()?;
        let deadline = (deadline > 0.0).then(|| Duration::from_secs_f64(deadline));
        Ok(CommonParameters { deadline, simulator, figures })
    }
}

impl Common {
    pub(super) fn new(node: &mut Node, parameters: CommonParameters) -> anyhow::Result<Common> {
        let CommonParameters { deadline, simulator, figures } = parameters;
        let simulator_parameters = ParameterClient::new(node, &simulator)?;
        Ok(Common { deadline, simulator_parameters, simulator, figures })
    }

    /// The simulator, or `None` if the node shut down before there was one.
    pub(super) fn connect<'node>(
        &self,
        node: &'node Node,
        connection: Connection,
    ) -> anyhow::Result<Option<Simulator<'node>>> {
        match Simulator::connect(node, connection, self.deadline) {
            Ok(simulator) => Ok(Some(simulator)),
            Err(SimulatorError::Shutdown) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// The simulator's parameters belong to the record of a run; a robot may have none.
    pub(super) fn record_simulator(
        &self,
        node: &Node,
        config: &mut BTreeMap<String, BTreeMap<String, ParameterValue>>,
    ) {
        match node.block_on(self.simulator_parameters.values(PARAMETER_DEADLINE)) {
            Ok(values) => drop(config.insert("sim_node".to_owned(), values)),
            Err(error) => warn!("config.yaml lacks the parameters of {}: {error}", self.simulator),
        }
    }
}

/// How long a test is, and of what.
pub(super) struct TestParameters {
    pub(super) episodes: u32,
    seed: u64,
    max_steps: u32,
}

impl TestParameters {
    pub(super) fn declare(
        parameters: &Parameters,
        episodes: &str,
        seed: &str,
        least: u64,
    ) -> anyhow::Result<TestParameters> {
        let episodes_are = "greedy test episodes";
        // The default seed is the same for every model, so that all are evaluated in the same rooms.
        let seed_is = "the seed of the test; its episodes are never those of a training";
        let steps_are = "steps after which a test episode counts as a failure";
        Ok(TestParameters {
            episodes: count(parameters, episodes, 1000, least..=10_000_000, episodes_are)? as u32,
            seed: count(parameters, seed, 1, 0..=LARGEST_SEED, seed_is)?,
            max_steps: count(parameters, "max_steps", 200, 1..=1_000_000, steps_are)? as u32,
        })
    }

    pub(super) fn plan(&self, scenario: &str) -> TestPlan {
        let TestParameters { episodes, seed, max_steps } = *self;
        TestPlan { scenario: scenario.to_owned(), episodes, seed, max_steps }
    }
}
