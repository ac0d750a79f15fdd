//! The parameters of another node, asked for over its services.

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

/// A client of another node's parameter services.
pub struct ParameterClient {
    list: ServiceClient<ListParameters>,
    get: ServiceClient<GetParameters>,
    set: ServiceClient<SetParameters>,
}

impl ParameterClient {
    /// A client for the node of that name, in this node's namespace unless it is absolute.
    pub fn new(node: &mut Node, remote: &str) -> Result<ParameterClient, NodeError> {
        Ok(ParameterClient {
            list: node.create_client(&format!("{remote}/list_parameters"))?,
            get: node.create_client(&format!("{remote}/get_parameters"))?,
            set: node.create_client(&format!("{remote}/set_parameters"))?,
        })
    }

    /// Every parameter that is set.
    pub async fn values(
        &self,
        deadline: Duration,
    ) -> Result<BTreeMap<String, ParameterValue>, CallError> {
        let everything = list_parameters::Request::default();
        let names = self.list.call(everything, Some(deadline)).await?.result.names;
        let request = get_parameters::Request { names: names.clone() };
        let values = self.get.call(request, Some(deadline)).await?.values;
        let set = names.into_iter().zip(&values);
        Ok(set
            .filter_map(|(name, value)| Some((name, ParameterValue::from_message(value)?)))
            .collect())
    }

    /// Sets a parameter; the inner error is the node's reason to refuse.
    pub async fn set(
        &self,
        name: &str,
        value: ParameterValue,
        deadline: Duration,
    ) -> Result<Result<(), String>, CallError> {
        let parameter = Parameter { name: name.to_owned(), value: value.into() };
        let request = set_parameters::Request { parameters: vec![parameter] };
        let results = self.set.call(request, Some(deadline)).await?.results;
        Ok(match results.into_iter().next() {
            Some(result) if result.successful => Ok(()),
            Some(result) => Err(result.reason),
            None => Err("the node answered nothing".to_owned()),
        })
    }
}
