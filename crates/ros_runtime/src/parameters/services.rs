//! The services that `ros2 param` talks to.
//!
//! ros2-client has them in its Spinner only, which also subscribes to `/clock` with a type that is
//! not ROS's, and it knows no descriptors. These answer from [`Parameters`].

use futures::{StreamExt, join};
use log::warn;
use ros2_client::{Message, Server, parameters::raw, rcl_interfaces as rcl};
use serde::{Deserialize, Serialize};

use super::{ParameterType, ParameterValue, Parameters};
use crate::logging::shortened;

/// The bytes of a reason to refuse a value.
const LONGEST_REASON: usize = 2000;

/// rcl_interfaces/srv/SetParameters and SetParametersAtomically ask the same.
pub(crate) type SetRequest = rcl::SetParametersRequest;

/// The six servers of a node.
pub(crate) struct ParameterServices {
    pub(crate) get: Server<rcl::GetParametersRequest, rcl::GetParametersResponse>,
    pub(crate) get_types: Server<rcl::GetParameterTypesRequest, rcl::GetParameterTypesResponse>,
    pub(crate) list: Server<rcl::ListParametersRequest, rcl::ListParametersResponse>,
    pub(crate) describe: Server<rcl::DescribeParametersRequest, DescribeResponse>,
    pub(crate) set: Server<SetRequest, rcl::SetParametersResponse>,
    pub(crate) set_atomically: Server<SetRequest, rcl::SetParametersAtomicallyResponse>,
}

/// rcl_interfaces/srv/DescribeParameters, the response.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct DescribeResponse {
    pub(crate) descriptors: Vec<raw::ParameterDescriptor>,
}

impl Message for DescribeResponse {}

impl ParameterServices {
    /// Answers for ever.
    pub(crate) async fn serve(self, parameters: Parameters) {
        join!(
            serve(self.get, |request: rcl::GetParametersRequest| {
                let values = request.names.iter().map(|name| message(value(&parameters, name)));
                rcl::GetParametersResponse { values: values.collect() }
            }),
            serve(self.get_types, |request: rcl::GetParameterTypesRequest| {
                let code =
                    |name: &String| value(&parameters, name).map_or(0, |value| value.kind().code());
                rcl::GetParameterTypesResponse { values: request.names.iter().map(code).collect() }
            }),
            serve(self.list, |request| list(&parameters, &request)),
            serve(self.describe, |request: rcl::DescribeParametersRequest| {
                let descriptors = request.names.iter().map(|name| descriptor(&parameters, name));
                DescribeResponse { descriptors: descriptors.collect() }
            }),
            serve(self.set, |request| rcl::SetParametersResponse {
                results: request.parameter.iter().map(|p| set(&parameters, p)).collect()
            }),
            serve(self.set_atomically, |request| {
                rcl::SetParametersAtomicallyResponse {
                    result: set_atomically(&parameters, &request.parameter),
                }
            }),
        );
    }
}

async fn serve<Request, Response>(
    server: Server<Request, Response>,
    answer: impl Fn(Request) -> Response,
) where
    Request: Message + Clone + 'static,
    Response: Message + 'static,
{
    let requests = server.receive_request_stream();
    futures::pin_mut!(requests);
    while let Some(request) = requests.next().await {
        let result = match request {
            Ok((id, request)) => {
                server.async_send_response(id, answer(request)).await.map_err(|e| e.to_string())
            }
            Err(error) => Err(error.to_string()),
        };
        if let Err(reason) = result {
            warn!("a call of a parameter service came to nothing: {reason}");
        }
    }
}

fn value(parameters: &Parameters, name: &str) -> Option<ParameterValue> {
    parameters.entry(name).map(|entry| entry.value)
}

/// "Not set" is the type 0 with every field empty.
fn message(value: Option<ParameterValue>) -> raw::ParameterValue {
    let is_set = value.is_some();
    let mut message = raw::ParameterValue::from(value.unwrap_or(ParameterValue::Bool(false)));
    if !is_set {
        message.ptype = raw::ParameterType::NOT_SET;
    }
    message
}

/// As rclcpp: prefixes end at dots, and depth counts the dots below a prefix; 0 is no limit.
fn list(
    parameters: &Parameters,
    request: &rcl::ListParametersRequest,
) -> rcl::ListParametersResponse {
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
    rcl::ListParametersResponse { result: rcl::ListParametersResult { names, prefixes } }
}

fn descriptor(parameters: &Parameters, name: &str) -> raw::ParameterDescriptor {
    let mut message = raw::ParameterDescriptor {
        name: name.to_owned(),
        r#type: raw::ParameterType::NOT_SET,
        description: String::new(),
        additional_constraints: String::new(),
        read_only: false,
        dynamic_typing: false,
        floating_point_range: vec![],
        integer_range: vec![],
    };
    if let Some(entry) = parameters.entry(name) {
        message.r#type = entry.value.kind().code();
        message.additional_constraints = entry.descriptor.additional_constraints();
        message.description = entry.descriptor.description;
        message.read_only = entry.descriptor.read_only;
        match (entry.descriptor.range, entry.value.kind()) {
            (Some((low, high)), ParameterType::Integer | ParameterType::IntegerArray) => {
                let range =
                    raw::IntegerRange { from_value: low as i64, to_value: high as i64, step: 1 };
                message.integer_range.push(range);
            }
            (Some((from_value, to_value)), _) => {
                let range = raw::FloatingPointRange { from_value, to_value, step: 0.0 };
                message.floating_point_range.push(range);
            }
            (None, _) => {}
        }
    }
    message
}

fn set(parameters: &Parameters, parameter: &raw::Parameter) -> raw::SetParametersResult {
    set_atomically(parameters, std::slice::from_ref(parameter))
}

fn set_atomically(parameters: &Parameters, changes: &[raw::Parameter]) -> raw::SetParametersResult {
    let value = |change: &raw::Parameter| match ParameterValue::from_message(&change.value) {
        Some(value) => Ok((change.name.clone(), value)),
        None => Err(format!("parameter '{}' cannot be unset", change.name)),
    };
    let values: Result<Vec<(String, ParameterValue)>, String> = changes.iter().map(value).collect();
    let result = values.and_then(|values| {
        let changes = values.iter().map(|(name, value)| (name.as_str(), value.clone()));
        parameters.set_all(changes).map_err(|error| error.to_string())
    });
    // What is refused is quoted, and may be as long as a message.
    raw::SetParametersResult {
        successful: result.is_ok(),
        reason: shortened(result.err().unwrap_or_default(), LONGEST_REASON),
    }
}
