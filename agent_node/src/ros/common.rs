//! The parameters and the simulator access that `train` and `evaluate` share.

use std::{collections::BTreeMap, time::Duration};

use learning::evaluation::EvaluationPlan;
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

/// The largest seed. Parameter limits are `f64`, which represents integers exactly up to this
/// value.
pub(super) const LARGEST_SEED: u64 = (1 << 53) - 1;
/// Timeout for reading the simulator's parameters, which are only recorded in config.yaml.
const PARAMETER_TIMEOUT: Duration = Duration::from_secs(10);

/// The parameters that `train` and `evaluate` share.
pub(super) struct CommonParameters {
    /// The parameter `simulator_timeout`; `None` if it is 0.
    deadline: Option<Duration>,
    simulator: String,
    figures: bool,
}

/// What `train` and `evaluate` need for the simulator, and whether they draw figures.
pub(super) struct Common {
    deadline: Option<Duration>,
    pub(super) simulator_parameters: ParameterClient,
    simulator: String,
    pub(super) figures: bool,
}

impl CommonParameters {
    /// Declares the parameters and rejects overrides of undeclared parameters, so it must be called
    /// after all other declarations. `namespace` is the namespace of the simulator whose parameters
    /// are recorded.
    pub(super) fn declare(
        parameters: &Parameters,
        namespace: &str,
    ) -> anyhow::Result<CommonParameters> {
        let deadline = parameters.declare(
            "simulator_timeout",
            120.0,
            Descriptor::read_only(
                "timeout, in seconds, for the services reset and step to become available and for \
                 each call to them; 0 disables it",
            )
            .range(0.0..=1e6),
        )?;
        let simulator = declare(
            parameters,
            "simulator",
            name_in(namespace, "sim_node"),
            "name of the simulator node, relative to the namespace of this node; train records the \
             simulator's parameters in config.yaml; train and evaluate change them temporarily, to \
             show a fixed room in the figures and for robustness",
        )?;
        let figures = declare(
            parameters,
            "figures",
            true,
            "draw some escapes after the evaluation and save them in the directory figures; \
             requires the topics tf and scene",
        )?;
        parameters.reject_undeclared()?;
        let deadline = (deadline > 0.0).then(|| Duration::from_secs_f64(deadline));
        Ok(CommonParameters { deadline, simulator, figures })
    }
}

impl Common {
    /// Creates the clients of the simulator's parameter services.
    pub(super) fn new(node: &mut Node, parameters: CommonParameters) -> anyhow::Result<Common> {
        let CommonParameters { deadline, simulator, figures } = parameters;
        let simulator_parameters = ParameterClient::new(node, &simulator)?;
        Ok(Common { deadline, simulator_parameters, simulator, figures })
    }

    /// Waits for the simulator. Returns `None` if the node shuts down in the meantime.
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

    /// Adds the simulator's parameters to `config`. Logs a warning if they are not available,
    /// because a robot may have none.
    pub(super) fn record_simulator(
        &self,
        node: &Node,
        config: &mut BTreeMap<String, BTreeMap<String, ParameterValue>>,
    ) {
        match node.block_on(self.simulator_parameters.values(PARAMETER_TIMEOUT)) {
            Ok(values) => drop(config.insert("sim_node".to_owned(), values)),
            Err(error) => warn!("config.yaml lacks the parameters of {}: {error}", self.simulator),
        }
    }
}

/// The parameters of an evaluation.
pub(super) struct EvaluationParameters {
    pub(super) episodes: u32,
    seed: u64,
    max_steps: u32,
}

impl EvaluationParameters {
    /// Declares the parameters. `episodes` and `seed` are the names of these two parameters, which
    /// differ between commands. A `minimum` of 0 allows skipping the evaluation.
    pub(super) fn declare(
        parameters: &Parameters,
        episodes: &str,
        seed: &str,
        minimum: u64,
    ) -> anyhow::Result<EvaluationParameters> {
        let episodes_help = match minimum {
            0 => "number of greedy evaluation episodes after training; 0 skips the evaluation",
            _ => "number of greedy evaluation episodes",
        };
        let seed_help = "evaluation seed, from which the seed and the scenario of each episode are \
                         derived; independent of the training seed";
        let steps_help = "step limit of an evaluation episode; the episode fails if the robot does \
                          not reach the exit within this limit";
        let limits = minimum..=10_000_000;
        Ok(EvaluationParameters {
            episodes: count(parameters, episodes, 1000, limits, episodes_help)? as u32,
            // The default is the same for every model, so that all models are evaluated on the same
            // episodes.
            seed: count(parameters, seed, 1, 0..=LARGEST_SEED, seed_help)?,
            max_steps: count(parameters, "max_steps", 200, 1..=1_000_000, steps_help)? as u32,
        })
    }

    /// Returns the plan for an evaluation in `scenario`.
    pub(super) fn plan(&self, scenario: &str) -> EvaluationPlan {
        let EvaluationParameters { episodes, seed, max_steps } = *self;
        EvaluationPlan { scenario: scenario.to_owned(), episodes, seed, max_steps }
    }
}
