//! The nodes of a command: their programs, parameters and arguments.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Command};

use crate::{
    command_line::{given_parameters, with_parameters},
    parameters::Parameters,
    programs,
};

/// The parameter of the simulator that sets all perturbations, and its default with preset robust.
pub const RANDOMIZATION: &str = "randomization";
pub const ROBUST_RANDOMIZATION: &str = "strong";

/// The agent and the simulator that a command starts.
pub struct Nodes {
    command: &'static str,
    /// Program of the agent.
    pub agent: PathBuf,
    /// Program of the simulator.
    pub simulator: PathBuf,
    agent_parameters: Parameters,
    simulator_parameters: Parameters,
}

impl Nodes {
    /// Finds the programs and queries them for their parameters.
    ///
    /// # Errors
    ///
    /// Returns an error if a program is not found or a query fails.
    pub fn query(command: &'static str) -> anyhow::Result<Nodes> {
        let (agent, simulator) = (programs::find("agent_node")?, programs::find("sim_node")?);
        let agent_parameters = Parameters::query(&agent, Some(command), &[])?;
        let mut simulator_parameters = Parameters::query(&simulator, None, &[])?;
        if command == "train" {
            simulator_parameters.set_default(RANDOMIZATION, ROBUST_RANDOMIZATION);
        }
        Ok(Nodes { command, agent, simulator, agent_parameters, simulator_parameters })
    }

    /// Returns the name of the command, which is the same for `evac` and the agent.
    pub fn command(&self) -> &'static str {
        self.command
    }

    /// Adds an option for each parameter of the nodes. A parameter that both nodes have becomes an
    /// option of the agent.
    pub fn add_options(&self, command: Command) -> Command {
        let ros = Arg::new("ros")
            .help("ROS arguments for the agent, for example: -- --log-level debug")
            .value_name("ROS ARGUMENTS")
            .num_args(0..)
            .last(true)
            .action(ArgAction::Append);
        let command =
            with_parameters(command.arg(ros), &self.agent_parameters, "Parameters of the agent");
        with_parameters(command, &self.simulator_parameters, "Parameters of the simulator")
    }

    /// Returns the ROS arguments of the agent and the resulting parameters. The arguments are
    /// `defaults`, the given options, and the arguments after `--`; later ones take precedence.
    ///
    /// # Errors
    ///
    /// Returns the error message of the agent if an argument is invalid.
    pub fn agent_arguments(
        &self,
        matches: &ArgMatches,
        defaults: Vec<String>,
    ) -> anyhow::Result<(Vec<String>, Parameters)> {
        // With SROS2, the enclave selects the keys. An --enclave after `--` takes precedence.
        let enclave = ["--ros-args", "--enclave", "/evac/agent_node"];
        let mut arguments = enclave.map(str::to_owned).to_vec();
        arguments.extend(defaults);
        arguments.extend(given_parameters(matches, &self.agent_parameters, None));
        arguments.extend(matches.get_many::<String>("ros").into_iter().flatten().cloned());
        arguments.push("--".to_owned());
        let parameters = Parameters::query(&self.agent, Some(self.command), &arguments)?;
        Ok((arguments, parameters))
    }

    /// Returns the given options that only the simulator has, as ROS arguments.
    pub fn simulator_options(&self, matches: &ArgMatches) -> Vec<String> {
        given_parameters(matches, &self.simulator_parameters, Some(&self.agent_parameters))
    }

    /// Returns the arguments of a simulator in `namespace`, which has no leading slash and is empty
    /// for the root namespace.
    ///
    /// # Errors
    ///
    /// Returns the error message of the simulator if an argument is invalid.
    pub fn simulator_arguments(
        &self,
        namespace: &str,
        options: &[String],
    ) -> anyhow::Result<Vec<String>> {
        let enclave = ["--ros-args", "--enclave", "/evac/sim_node"];
        let mut arguments = enclave.map(str::to_owned).to_vec();
        if !namespace.is_empty() {
            arguments.extend(["-r".to_owned(), format!("__ns:=/{namespace}")]);
        }
        arguments.extend_from_slice(options);
        arguments.push("--".to_owned());
        Parameters::query(&self.simulator, None, &arguments)?;
        Ok(arguments)
    }
}
