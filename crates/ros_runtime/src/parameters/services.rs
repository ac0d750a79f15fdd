//! The parameter services of a node, which `ros2 param` calls.
//!
//! ros2-client provides such services only in its Spinner, which subscribes to `/clock` with the
//! wrong type and does not support descriptors.

use futures::join;
use ros_interfaces::{
    RosService,
    rcl_interfaces::{
        DescribeParameters, FloatingPointRange, GetParameterTypes, GetParameters, IntegerRange,
        ListParameters, ListParametersResult, Parameter, ParameterDescriptor,
        ParameterValue as Message, SetParameters, SetParametersAtomically, SetParametersResult,
        describe_parameters, get_parameter_types, get_parameters, list_parameters, set_parameters,
        set_parameters_atomically,
    },
};

use super::{ParameterType, ParameterValue, Parameters};
use crate::{escape::escaped, logging::shortened, server::ServiceServer};

/// The maximum length of the reason for a failed request, in bytes.
const LONGEST_REASON: usize = 2000;

/// The servers for the parameter services of a node.
pub(crate) struct ParameterServices {
    pub(crate) get: ServiceServer<GetParameters>,
    pub(crate) get_types: ServiceServer<GetParameterTypes>,
    pub(crate) list: ServiceServer<ListParameters>,
    pub(crate) describe: ServiceServer<DescribeParameters>,
    pub(crate) set: ServiceServer<SetParameters>,
    pub(crate) set_atomically: ServiceServer<SetParametersAtomically>,
}

impl ParameterServices {
    /// Serves requests until the task is dropped.
    pub(crate) async fn serve(self, parameters: Parameters) {
        let values = |request: get_parameters::Request| {
            let values = request.names.iter().map(|name| message(value(&parameters, name)));
            get_parameters::Response { values: values.collect() }
        };
        let types = |request: get_parameter_types::Request| {
            let code =
                |name: &String| value(&parameters, name).map_or(0, |value| value.kind().code());
            get_parameter_types::Response { types: request.names.iter().map(code).collect() }
        };
        let descriptors = |request: describe_parameters::Request| {
            let descriptors = request.names.iter().map(|name| descriptor(&parameters, name));
            describe_parameters::Response { descriptors: descriptors.collect() }
        };
        let results = |request: set_parameters::Request| set_parameters::Response {
            results: set_each(&parameters, &request.parameters),
        };
        let result = |request: set_parameters_atomically::Request| {
            let result = set_atomically(&parameters, &request.parameters);
            set_parameters_atomically::Response { result }
        };
        join!(
            serve(self.get, values),
            serve(self.get_types, types),
            serve(self.list, |request| list(&parameters, &request)),
            serve(self.describe, descriptors),
            serve(self.set, results),
            serve(self.set_atomically, result),
        );
    }
}

async fn serve<S: RosService>(
    server: ServiceServer<S>,
    respond: impl Fn(S::Request) -> S::Response,
) {
    loop {
        let (id, request) = server.next_request().await;
        server.answer(id, respond(request)).await;
    }
}

fn value(parameters: &Parameters, name: &str) -> Option<ParameterValue> {
    parameters.entry(name).map(|entry| entry.value)
}

/// Returns the message for a value, or a message of type "not set" (0) if there is no value.
fn message(value: Option<ParameterValue>) -> Message {
    value.map_or_else(Message::default, Message::from)
}

/// Lists parameters as rclcpp does: a prefix ends at a dot, and the depth is the maximum number of
/// levels below the prefix, where 0 means no limit.
fn list(parameters: &Parameters, request: &list_parameters::Request) -> list_parameters::Response {
    let within = |name: &str| match request.depth {
        0 => true,
        depth => (name.matches('.').count() as u64) < depth,
    };
    let names: Vec<String> = parameters
        .values()
        .into_keys()
        .filter(|name| match request.prefixes.as_slice() {
            [] => within(name),
            prefixes => prefixes.iter().any(|prefix| {
                name == prefix
                    || name
                        .strip_prefix(prefix.as_str())
                        .and_then(|rest| rest.strip_prefix('.'))
                        .is_some_and(within)
            }),
        })
        .collect();
    let mut prefixes: Vec<String> =
        names.iter().filter_map(|name| name.rsplit_once('.')).map(|(p, _)| p.to_owned()).collect();
    prefixes.sort();
    prefixes.dedup();
    list_parameters::Response { result: ListParametersResult { names, prefixes } }
}

fn descriptor(parameters: &Parameters, name: &str) -> ParameterDescriptor {
    let mut message =
        ParameterDescriptor { name: name.to_owned(), ..ParameterDescriptor::default() };
    if let Some(entry) = parameters.entry(name) {
        message.r#type = entry.value.kind().code();
        message.additional_constraints = entry.descriptor.additional_constraints();
        message.description = entry.descriptor.description;
        message.read_only = entry.descriptor.read_only;
        match (entry.descriptor.range, entry.value.kind()) {
            (Some((low, high)), ParameterType::Integer | ParameterType::IntegerArray) => {
                let range = IntegerRange { from_value: low as i64, to_value: high as i64, step: 1 };
                message.integer_range.push(range);
            }
            (Some((from_value, to_value)), _) => {
                let range = FloatingPointRange { from_value, to_value, step: 0.0 };
                message.floating_point_range.push(range);
            }
            (None, _) => {}
        }
    }
    message
}

/// Sets each parameter on its own. Presets come first, so that a parameter file whose values differ
/// from its preset can be loaded in any order.
fn set_each(parameters: &Parameters, changes: &[Parameter]) -> Vec<SetParametersResult> {
    let mut order: Vec<usize> = (0..changes.len()).collect();
    order.sort_by_key(|index| !parameters.has_implications(&changes[*index].name));
    let mut results = vec![SetParametersResult::default(); changes.len()];
    for index in order {
        results[index] = set_atomically(parameters, &changes[index..=index]);
    }
    results
}

fn set_atomically(parameters: &Parameters, changes: &[Parameter]) -> SetParametersResult {
    let value = |change: &Parameter| match ParameterValue::from_message(&change.value) {
        Some(value) => Ok((change.name.clone(), value)),
        None => Err(format!("parameter '{}' cannot be unset", escaped(&change.name))),
    };
    let values: Result<Vec<(String, ParameterValue)>, String> = changes.iter().map(value).collect();
    let result = values.and_then(|values| {
        let changes = values.iter().map(|(name, value)| (name.as_str(), value.clone()));
        parameters.set_all(changes).map_err(|error| error.to_string())
    });
    // An error quotes the rejected value, which can be as long as a message.
    SetParametersResult {
        successful: result.is_ok(),
        reason: shortened(result.err().unwrap_or_default(), LONGEST_REASON),
    }
}
