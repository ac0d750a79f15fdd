//! A client for the parameter services of another node.

use std::{collections::BTreeMap, time::Duration};

use ros_interfaces::rcl_interfaces::{
    GetParameters, ListParameters, Parameter, SetParameters, get_parameters, list_parameters,
    set_parameters,
};

use super::ParameterValue;
use crate::{
    node::{Node, NodeError},
    service::{CallError, ServiceClient},
};

/// A client for the parameter services of another node.
///
/// # Examples
///
/// ```no_run
/// use std::time::Duration;
///
/// use ros_runtime::{
///     Arguments, Node,
///     parameters::{ParameterClient, ParameterValue},
/// };
///
/// let mut node = Node::new("inspector", &Arguments::from_environment()?, &[])?;
/// let camera = ParameterClient::new(&mut node, "camera")?;
/// let timeout = Duration::from_secs(5);
/// println!("{:?}", node.block_on(camera.values(timeout))?);
/// node.block_on(camera.set("rate", ParameterValue::Double(20.0), timeout))??;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ParameterClient {
    list: ServiceClient<ListParameters>,
    get: ServiceClient<GetParameters>,
    set: ServiceClient<SetParameters>,
}

impl ParameterClient {
    /// Creates a client for the node named `remote`, which is in the namespace of `node` unless the
    /// name is absolute.
    ///
    /// # Errors
    ///
    /// Returns an error if the name is invalid or if DDS rejects a client.
    pub fn new(node: &mut Node, remote: &str) -> Result<ParameterClient, NodeError> {
        Ok(ParameterClient {
            list: node.create_client(&format!("{remote}/list_parameters"))?,
            get: node.create_client(&format!("{remote}/get_parameters"))?,
            set: node.create_client(&format!("{remote}/set_parameters"))?,
        })
    }

    /// Returns the values of all parameters that are set, by name, except byte arrays.
    ///
    /// # Errors
    ///
    /// Returns an error if one of the two calls fails; each waits up to `deadline`.
    ///
    /// # Panics
    ///
    /// Same as [`ServiceClient::call`].
    pub async fn values(
        &self,
        deadline: Duration,
    ) -> Result<BTreeMap<String, ParameterValue>, CallError> {
        let all = list_parameters::Request::default();
        let names = self.list.call(all, Some(deadline)).await?.result.names;
        let request = get_parameters::Request { names: names.clone() };
        let values = self.get.call(request, Some(deadline)).await?.values;
        let set = names.into_iter().zip(&values);
        Ok(set
            .filter_map(|(name, value)| Some((name, ParameterValue::from_message(value)?)))
            .collect())
    }

    /// Sets a parameter.
    ///
    /// # Errors
    ///
    /// Returns the outer error if the call fails or there is no response within `deadline`, and the
    /// inner error, with the reason, if the node rejects the value.
    ///
    /// # Panics
    ///
    /// Same as [`ServiceClient::call`].
    pub async fn set(
        &self,
        name: &str,
        value: ParameterValue,
        deadline: Duration,
    ) -> Result<Result<(), String>, CallError> {
        self.set_all([(name, value)], deadline).await
    }

    /// Sets several parameters, each on its own: after an error, some may be set and others not.
    ///
    /// # Errors
    ///
    /// Returns the outer error if the call fails or there is no response within `deadline`, and the
    /// inner error, with the first reason, if the node rejects a value.
    ///
    /// # Panics
    ///
    /// Same as [`ServiceClient::call`].
    pub async fn set_all<'a>(
        &self,
        changes: impl IntoIterator<Item = (&'a str, ParameterValue)>,
        deadline: Duration,
    ) -> Result<Result<(), String>, CallError> {
        let parameters: Vec<Parameter> = changes
            .into_iter()
            .map(|(name, value)| Parameter { name: name.to_owned(), value: value.into() })
            .collect();
        let count = parameters.len();
        let request = set_parameters::Request { parameters };
        let results = self.set.call(request, Some(deadline)).await?.results;
        if results.len() != count {
            return Ok(Err(format!("the node returned {} results for {count}", results.len())));
        }
        let failed = results.into_iter().find(|result| !result.successful);
        Ok(failed.map_or(Ok(()), |result| Err(result.reason)))
    }
}
