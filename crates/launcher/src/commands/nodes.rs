//! The nodes of a command: their programs, their parameters as options, and their arguments.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Command};

use crate::{
    command_line::{given, with_parameters},
    parameters::Parameters,
    programs,
};

/// The agent and the simulator of a command.
pub struct Nodes {
    command: &'static str,
    /// The program of the agent.
    pub agent: PathBuf,
    /// The program of the simulator.
    pub simulator: PathBuf,
    agent_options: Parameters,
    simulator_options: Parameters,
}

impl Nodes {
    /// Finds the programs and asks them for their parameters.
    pub fn of(command: &'static str) -> anyhow::Result<Nodes> {
        let (agent, simulator) = (programs::find("agent_node")?, programs::find("sim_node")?);
        let agent_options = Parameters::of(&agent, Some(command), &[])?;
        let simulator_options = Parameters::of(&simulator, None, &[])?;
        Ok(Nodes { command, agent, simulator, agent_options, simulator_options })
    }

    /// The command, which is also that of the agent.
    pub fn command(&self) -> &'static str {
        self.command
    }

    /// Adds an option for each parameter; one that both nodes have is the agent's.
    pub fn add_options(&self, command: Command) -> Command {
        let ros = Arg::new("ros")
            .help("ROS arguments of the agent, after --: -p learning_rate:=0.001")
            .value_name("ROS ARGUMENTS")
            .num_args(0..)
            .last(true)
            .action(ArgAction::Append);
        let command =
            with_parameters(command.arg(ros), &self.agent_options, "Parameters of the agent");
        with_parameters(command, &self.simulator_options, "Parameters of the simulator")
    }

    /// The ROS arguments of the agent: these, the given options, and what stands after `--`; and the
    /// parameters that they come to. The error is the node's.
    pub fn agent_arguments(
        &self,
        matches: &ArgMatches,
        defaults: Vec<String>,
    ) -> anyhow::Result<(Vec<String>, Parameters)> {
        // Whose keys it has, where there is security; another one that is given has precedence.
        let enclave = ["--ros-args", "--enclave", "/evac/agent_node"];
        let mut arguments = enclave.map(str::to_owned).to_vec();
        arguments.extend(defaults);
        arguments.extend(given(matches, &self.agent_options, None));
        arguments.extend(matches.get_many::<String>("ros").into_iter().flatten().cloned());
        arguments.push("--".to_owned());
        let parameters = Parameters::of(&self.agent, Some(self.command), &arguments)?;
        Ok((arguments, parameters))
    }

    /// The options of the simulator that were given.
    pub fn simulator_options(&self, matches: &ArgMatches) -> Vec<String> {
        given(matches, &self.simulator_options, Some(&self.agent_options))
    }

    /// The arguments of a simulator in a namespace, which is empty for that of the agent. The error is
    /// the node's.
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
        Parameters::of(&self.simulator, None, &arguments)?;
        Ok(arguments)
    }
}
