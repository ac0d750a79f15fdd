//! The parameters of another node, asked for over its services.

use std::{collections::BTreeMap, time::Duration};

use ros_interfaces::RosService;
use ros2_client::{parameters::raw, rcl_interfaces as rcl};

use super::ParameterValue;
use crate::{
    node::{Node, NodeError},
    service::{CallError, ServiceClient},
};

struct ListParameters;

impl RosService for ListParameters {
    const PACKAGE: &str = "rcl_interfaces";
    const NAME: &str = "ListParameters";
    type Request = rcl::ListParametersRequest;
    type Response = rcl::ListParametersResponse;
}

struct GetParameters;

impl RosService for GetParameters {
    const PACKAGE: &str = "rcl_interfaces";
    const NAME: &str = "GetParameters";
    type Request = rcl::GetParametersRequest;
    type Response = rcl::GetParametersResponse;
}

struct SetParameters;

impl RosService for SetParameters {
    const PACKAGE: &str = "rcl_interfaces";
    const NAME: &str = "SetParameters";
    type Request = rcl::SetParametersRequest;
    type Response = rcl::SetParametersResponse;
}

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
        let everything = rcl::ListParametersRequest { prefixes: vec![], depth: 0 };
        let names = self.list.call(everything, Some(deadline)).await?.result.names;
        let request = rcl::GetParametersRequest { names: names.clone() };
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
        let parameter = raw::Parameter { name: name.to_owned(), value: value.into() };
        let request = rcl::SetParametersRequest { parameter: vec![parameter] };
        let results = self.set.call(request, Some(deadline)).await?.results;
        Ok(match results.into_iter().next() {
            Some(result) if result.successful => Ok(()),
            Some(result) => Err(result.reason),
            None => Err("the node answered nothing".to_owned()),
        })
    }
}
