//! What options a node has: it tells its parameters, and what is wrong with those that it is given,
//! without joining a DDS domain.

use std::{collections::BTreeMap, path::Path, process::Command};

use anyhow::{Context, bail};
use serde::Deserialize;
use serde_json::Value;

/// A parameter as its node tells it.
#[derive(Clone, Debug, Deserialize)]
pub struct Parameter {
    /// As ROS has it, such as `max_steps`.
    pub name: String,
    /// What it is for.
    pub description: String,
    /// What kind of value it takes, in words.
    pub expected: String,
    /// The value with the arguments that the node was given.
    pub value: Value,
    /// The value that it has otherwise.
    pub default: Value,
    /// The values of a string, if they can be listed.
    pub choices: Vec<String>,
    /// The least and the greatest value of a number.
    pub range: Option<(f64, f64)>,
}

/// The parameters of a node, by their names.
#[derive(Clone, Debug, Default)]
pub struct Parameters(BTreeMap<String, Parameter>);

impl Parameters {
    /// Asks a node; `command` is one of its own, if it has several. The error is the node's: what is
    /// wrong with the arguments, and what would be right.
    pub fn of(
        node: &Path,
        command: Option<&str>,
        arguments: &[String],
    ) -> anyhow::Result<Parameters> {
        let output = Command::new(node)
            .arg("parameters")
            .args(command)
            .args(arguments)
            .output()
            .with_context(|| node.display().to_string())?;
        if !output.status.success() {
            let error = String::from_utf8_lossy(&output.stderr);
            let error = error.trim();
            bail!("{}", error.split_once(": ").map_or(error, |(_, reason)| reason));
        }
        let all: Vec<Parameter> = serde_json::from_slice(&output.stdout)
            .with_context(|| format!("what {} says of its parameters", node.display()))?;
        Ok(Parameters(all.into_iter().map(|one| (one.name.clone(), one)).collect()))
    }

    /// The parameters.
    pub fn iter(&self) -> impl Iterator<Item = &Parameter> {
        self.0.values()
    }

    /// The value of a parameter; null if there is none.
    pub fn value(&self, name: &str) -> &Value {
        self.0.get(name).map_or(&Value::Null, |parameter| &parameter.value)
    }

    /// The value of a string parameter; empty if there is none.
    pub fn text(&self, name: &str) -> &str {
        self.value(name).as_str().unwrap_or_default()
    }

    /// The value of a parameter that counts something; 0 if there is none.
    pub fn count(&self, name: &str) -> u64 {
        self.value(name).as_u64().unwrap_or_default()
    }
}

/// `-p NAME:=VALUE` of a value that a person has written.
pub fn assignment(parameter: &Parameter, value: &str) -> [String; 2] {
    let value = match parameter.default {
        // As a string in YAML, which a value would otherwise be read as.
        Value::String(_) => format!("'{}'", value.replace('\'', "''")),
        _ => value.to_owned(),
    };
    ["-p".to_owned(), format!("{}:={value}", parameter.name)]
}
