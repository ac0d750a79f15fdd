//! The type descriptions of a node's topics and services, served by `~/get_type_description`
//! (REP-2016).

use std::{collections::BTreeMap, sync::Arc};

use parking_lot::{Mutex, MutexGuard};
use ros_interfaces::{
    Interfaces,
    type_description_interfaces::{
        GetTypeDescription, TypeDescription,
        get_type_description::{Request, Response},
    },
};
use thiserror::Error;

use crate::{
    escape::escaped,
    parameters::{Descriptor, ParameterError, Parameters},
    server::ServiceServer,
};

/// The parameter that enables the service, as in rclcpp and rclpy.
const START_TYPE_DESCRIPTION_SERVICE: &str = "start_type_description_service";

/// The reason for a failed request.
#[derive(Debug, Error, PartialEq)]
enum DescriptionError {
    #[error("unknown type '{}' (expected: {})", escaped(.name), used.join(", "))]
    NotUsed { name: String, used: Vec<String> },
    #[error("type_hash is '{}': expected {expected} for {name}", escaped(.hash))]
    OtherHash { hash: String, expected: String, name: String },
}

/// Returns the USER_DATA that discovery announces for an endpoint with a DDS type, such as
/// `sensor_msgs::msg::dds_::Image_`: the type hash, in the format of rmw_dds_common in Jazzy. The
/// data is empty for a type without a definition.
pub(crate) fn user_data(interfaces: &Interfaces, dds_type: &str) -> Vec<u8> {
    let hash = ros_name(dds_type).and_then(|name| interfaces.hash(&name));
    hash.map_or_else(Vec::new, |hash| format!("typehash={hash};").into_bytes())
}

/// Returns the full ROS name of a DDS type, such as `sensor_msgs/msg/Image` or
/// `std_srvs/srv/Trigger_Request`.
fn ros_name(dds_type: &str) -> Option<String> {
    let (package, name) = dds_type.split_once("::dds_::")?;
    Some(format!("{}/{}", package.replace("::", "/"), name.strip_suffix('_')?))
}

/// The types that a node uses. Clones share them.
#[derive(Clone)]
pub(crate) struct Types {
    are_served: bool,
    interfaces: Arc<Interfaces>,
    descriptions: Arc<Mutex<BTreeMap<String, TypeDescription>>>,
}

impl Types {
    /// Declares the parameter that enables the service and returns an empty set of types.
    pub(crate) fn declare(
        parameters: &Parameters,
        interfaces: Arc<Interfaces>,
    ) -> Result<Types, ParameterError> {
        let descriptor = Descriptor::read_only("serve ~/get_type_description");
        let are_served = parameters.declare(START_TYPE_DESCRIPTION_SERVICE, true, descriptor)?;
        Ok(Types { are_served, interfaces, descriptions: Arc::default() })
    }

    /// Returns whether the service is enabled.
    pub(crate) fn are_served(&self) -> bool {
        self.are_served
    }

    /// Adds a type by its full name, such as `std_msgs/msg/Header`, if it has a definition.
    pub(crate) fn add(&self, full_name: &str) {
        if let Some(description) = self.interfaces.describe(full_name) {
            self.descriptions().insert(full_name.to_owned(), description);
        }
    }

    /// Serves requests until the task is dropped.
    pub(crate) async fn serve(self, server: ServiceServer<GetTypeDescription>) {
        loop {
            let (id, request) = server.next_request().await;
            let response = self.describe(request).unwrap_or_else(|error| Response {
                failure_reason: error.to_string(),
                ..Response::default()
            });
            server.answer(id, response).await;
        }
    }

    fn describe(&self, request: Request) -> Result<Response, DescriptionError> {
        let Request { type_name: name, type_hash: hash, include_type_sources } = request;
        let descriptions = self.descriptions();
        let Some(description) = descriptions.get(&name) else {
            let used = descriptions.keys().cloned().collect();
            return Err(DescriptionError::NotUsed { name, used });
        };
        let expected = self.interfaces.hash(&name).unwrap_or_default();
        if hash != expected {
            return Err(DescriptionError::OtherHash { hash, expected, name });
        }
        let type_sources =
            if include_type_sources { self.interfaces.sources(&name) } else { vec![] };
        Ok(Response {
            successful: true,
            type_description: description.clone(),
            type_sources,
            ..Response::default()
        })
    }

    fn descriptions(&self) -> MutexGuard<'_, BTreeMap<String, TypeDescription>> {
        self.descriptions.lock()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interfaces() -> Interfaces {
        Interfaces::with(&[("my_msgs/srv/Move", "float32 speed\n---\nbool success")]).unwrap()
    }

    /// Returns the response of a node that uses two defined types.
    fn response(name: &str, hash: &str, include_type_sources: bool) -> Result<Response, String> {
        let (are_served, descriptions) = (true, Arc::default());
        let types = Types { are_served, interfaces: Arc::new(interfaces()), descriptions };
        for name in ["std_msgs/msg/Header", "my_msgs/srv/Move", "other_msgs/msg/Unknown"] {
            types.add(name);
        }
        let (type_name, type_hash) = (name.to_owned(), hash.to_owned());
        let request = Request { type_name, type_hash, include_type_sources };
        types.describe(request).map_err(|error| error.to_string())
    }

    fn hash(name: &str) -> String {
        interfaces().hash(name).unwrap()
    }

    #[test]
    fn discovery_announces_the_hash_of_a_type() {
        for (dds_type, name) in [
            ("sensor_msgs::msg::dds_::Image_", "sensor_msgs/msg/Image"),
            ("my_msgs::srv::dds_::Move_Request_", "my_msgs/srv/Move_Request"),
            ("my_msgs::srv::dds_::Move_Response_", "my_msgs/srv/Move_Response"),
            (
                "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
                "rmw_dds_common/msg/ParticipantEntitiesInfo",
            ),
        ] {
            let expected = format!("typehash={};", hash(name)).into_bytes();
            assert_eq!(user_data(&interfaces(), dds_type), expected, "{dds_type}");
        }
        for unknown in
            ["", "Image", "other_msgs::msg::dds_::Unknown_", "sensor_msgs::msg::dds_::Image"]
        {
            assert_eq!(user_data(&interfaces(), unknown), b"", "{unknown}");
        }
    }

    #[test]
    fn describes_a_type_that_the_node_uses() {
        const HEADER: &str = "std_msgs/msg/Header";
        let header = interfaces().describe(HEADER).unwrap();
        let brief = response(HEADER, &hash(HEADER), false).unwrap();
        assert!(brief.successful && brief.failure_reason.is_empty());
        assert_eq!((&brief.type_description, brief.type_sources), (&header, vec![]));
        let full = response(HEADER, &hash(HEADER), true).unwrap();
        assert_eq!(full.type_description, header);
        assert_eq!(full.type_sources, interfaces().sources(HEADER));
    }

    #[test]
    fn rejects_unused_types_and_other_hashes() {
        let unused = "unknown type 'std_msgs/msg/ColorRGBA' (expected: my_msgs/srv/Move, \
                      std_msgs/msg/Header)";
        assert_eq!(response("std_msgs/msg/ColorRGBA", "", true), Err(unused.to_owned()));
        let hash = hash("std_msgs/msg/Header");
        let other = format!("type_hash is 'RIHS01_': expected {hash} for std_msgs/msg/Header");
        assert_eq!(response("std_msgs/msg/Header", "RIHS01_", true), Err(other));
    }

    #[test]
    fn errors_escape_the_name_and_the_hash_of_the_request() {
        let unused = r"unknown type 'a\nb' (expected: my_msgs/srv/Move, std_msgs/msg/Header)";
        assert_eq!(response("a\nb", "", true), Err(unused.to_owned()));
        let hash = hash("std_msgs/msg/Header");
        let other = format!(r"type_hash is 'a\nb': expected {hash} for std_msgs/msg/Header");
        assert_eq!(response("std_msgs/msg/Header", "a\nb", true), Err(other));
    }
}
