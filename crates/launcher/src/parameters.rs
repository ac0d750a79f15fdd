//! The parameters of a node. The node itself lists them and validates its arguments, without
//! joining a DDS domain.

use std::{collections::BTreeMap, path::Path, process::Command};

use anyhow::{Context, bail};
use serde::Deserialize;
use serde_json::Value;

/// A parameter, as printed by the command `parameters` of its node.
#[derive(Clone, Debug, Deserialize)]
pub struct Parameter {
    /// ROS name, e.g. `max_steps`.
    pub name: String,
    /// Description for the user.
    pub description: String,
    /// Type of the value, e.g. `an integer`.
    pub expected: String,
    /// Value that results from the node's arguments.
    pub value: Value,
    /// Default value.
    pub default: Value,
    /// Valid values of a string parameter; empty if every string is valid.
    pub choices: Vec<String>,
    /// Minimum and maximum of a numeric parameter; `None` if the parameter has no range.
    pub range: Option<(f64, f64)>,
}

/// The parameters of a node, by name.
#[derive(Clone, Debug, Default)]
pub struct Parameters(BTreeMap<String, Parameter>);

impl Parameters {
    /// Queries a node for its parameters and their values with the given arguments. `command` is
    /// required for a node that has several commands.
    ///
    /// # Errors
    ///
    /// Returns the error message of the node if it rejects the arguments, or an error if the node
    /// cannot be started or its output is not valid.
    pub fn query(
        node: &Path,
        command: Option<&str>,
        arguments: &[String],
    ) -> anyhow::Result<Parameters> {
        let output = Command::new(node)
            .arg("parameters")
            .args(command)
            .args(arguments)
            .output()
            .with_context(|| format!("cannot start {}", node.display()))?;
        if !output.status.success() {
            let error = String::from_utf8_lossy(&output.stderr);
            let error = error.trim();
            // The name of the node is removed from the message.
            bail!("{}", error.split_once(": ").map_or(error, |(_, reason)| reason));
        }
        let parameters: Vec<Parameter> = serde_json::from_slice(&output.stdout)
            .with_context(|| format!("invalid output of '{} parameters'", node.display()))?;
        Ok(Parameters(parameters.into_iter().map(|one| (one.name.clone(), one)).collect()))
    }

    /// Changes the default of a parameter that is shown in help texts, if there is such a parameter.
    pub fn set_default(&mut self, name: &str, default: &str) {
        if let Some(parameter) = self.0.get_mut(name) {
            parameter.default = default.into();
        }
    }

    /// Returns the parameters in alphabetical order.
    pub fn iter(&self) -> impl Iterator<Item = &Parameter> {
        self.0.values()
    }

    /// Returns the value of a parameter, or null if there is no such parameter.
    pub fn value(&self, name: &str) -> &Value {
        self.0.get(name).map_or(&Value::Null, |parameter| &parameter.value)
    }

    /// Returns the value of a string parameter, or an empty string if there is no such parameter.
    pub fn text(&self, name: &str) -> &str {
        self.value(name).as_str().unwrap_or_default()
    }

    /// Returns the value of a non-negative integer parameter, or 0 if there is no such parameter.
    pub fn count(&self, name: &str) -> u64 {
        self.value(name).as_u64().unwrap_or_default()
    }
}

/// Returns the ROS arguments `-p NAME:=VALUE` for a value from the command line.
pub fn assignment(parameter: &Parameter, value: &str) -> [String; 2] {
    let value = match parameter.default {
        // Quoted, because YAML would read a value such as 1 or true as another type.
        Value::String(_) => format!("'{}'", value.replace('\'', "''")),
        _ => value.to_owned(),
    };
    ["-p".to_owned(), format!("{}:={value}", parameter.name)]
}
