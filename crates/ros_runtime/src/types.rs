//! What the topics and services of a node carry, for whoever asks `~/get_type_description`
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
    parameters::{Descriptor, ParameterError, Parameters},
    server::ServiceServer,
};

/// Whether the service is there; rclcpp and rclpy know the parameter by this name, too.
const START_TYPE_DESCRIPTION_SERVICE: &str = "start_type_description_service";

/// Why a type is not described.
#[derive(Debug, Error, PartialEq)]
enum Refusal {
    #[error("type_name is '{name}': this node has {}", used.join(", "))]
    NotUsed { name: String, used: Vec<String> },
    #[error("type_hash is '{hash}': expected {expected} for {name}")]
    OtherHash { hash: String, expected: String, name: String },
}

/// What discovery announces with an endpoint of this DDS type, such as
/// `sensor_msgs::msg::dds_::Image_`: the type's hash, as Jazzy's rmw_dds_common writes it. Nothing for
/// a type without a definition.
pub(crate) fn user_data(interfaces: &Interfaces, dds_type: &str) -> Vec<u8> {
    let hash = ros_name(dds_type).and_then(|name| interfaces.hash(&name));
    hash.map_or_else(Vec::new, |hash| format!("typehash={hash};").into_bytes())
}

/// The full name of a type, such as `sensor_msgs/msg/Image` or `std_srvs/srv/Trigger_Request`, by its
/// name in DDS.
fn ros_name(dds_type: &str) -> Option<String> {
    let (package, name) = dds_type.split_once("::dds_::")?;
    Some(format!("{}/{}", package.replace("::", "/"), name.strip_suffix('_')?))
}

/// The types that a node uses; a cheap handle that can be shared.
#[derive(Clone)]
pub(crate) struct Types {
    are_served: bool,
    interfaces: Arc<Interfaces>,
    descriptions: Arc<Mutex<BTreeMap<String, TypeDescription>>>,
}

impl Types {
    /// No types yet; the parameter that says whether they are served is declared here.
    pub(crate) fn declare(
        parameters: &Parameters,
        interfaces: Arc<Interfaces>,
    ) -> Result<Types, ParameterError> {
        let descriptor = Descriptor::read_only("serve ~/get_type_description");
        let are_served = parameters.declare(START_TYPE_DESCRIPTION_SERVICE, true, descriptor)?;
        Ok(Types { are_served, interfaces, descriptions: Arc::default() })
    }

    /// Whether they are to be served.
    pub(crate) fn are_served(&self) -> bool {
        self.are_served
    }

    /// Adds the type with this full name, such as `std_msgs/msg/Header`, if it has a definition.
    pub(crate) fn add(&self, full_name: &str) {
        if let Some(description) = self.interfaces.describe(full_name) {
            self.descriptions().insert(full_name.to_owned(), description);
        }
    }

    /// Answers for ever.
    pub(crate) async fn serve(self, server: ServiceServer<GetTypeDescription>) {
        loop {
            let (id, request) = server.next_request().await;
            let response = self.describe(request).unwrap_or_else(|refusal| Response {
                failure_reason: refusal.to_string(),
                ..Response::default()
            });
            server.answer(id, response).await;
        }
    }

    fn describe(&self, request: Request) -> Result<Response, Refusal> {
        let Request { type_name: name, type_hash: hash, include_type_sources } = request;
        let descriptions = self.descriptions();
        let Some(description) = descriptions.get(&name) else {
            return Err(Refusal::NotUsed { name, used: descriptions.keys().cloned().collect() });
        };
        let expected = self.interfaces.hash(&name).unwrap_or_default();
        if hash != expected {
            return Err(Refusal::OtherHash { hash, expected, name });
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

    /// The answer of a node with two types.
    fn answer(name: &str, hash: &str, include_type_sources: bool) -> Result<Response, String> {
        let (are_served, descriptions) = (true, Arc::default());
        let types = Types { are_served, interfaces: Arc::new(interfaces()), descriptions };
        for name in ["std_msgs/msg/Header", "my_msgs/srv/Move", "other_msgs/msg/Unknown"] {
            types.add(name);
        }
        let (type_name, type_hash) = (name.to_owned(), hash.to_owned());
        let request = Request { type_name, type_hash, include_type_sources };
        types.describe(request).map_err(|refusal| refusal.to_string())
    }

    fn hash(name: &str) -> String {
        interfaces().hash(name).unwrap()
    }

    #[test]
    fn discovery_announces_the_hash_of_a_message() {
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
    fn a_type_that_is_used_is_described() {
        const HEADER: &str = "std_msgs/msg/Header";
        let header = interfaces().describe(HEADER).unwrap();
        let brief = answer(HEADER, &hash(HEADER), false).unwrap();
        assert!(brief.successful && brief.failure_reason.is_empty());
        assert_eq!((&brief.type_description, brief.type_sources), (&header, vec![]));
        let full = answer(HEADER, &hash(HEADER), true).unwrap();
        assert_eq!(full.type_description, header);
        assert_eq!(full.type_sources, interfaces().sources(HEADER));
    }

    #[test]
    fn refusals_say_what_would_be_right() {
        let unused = "type_name is 'std_msgs/msg/ColorRGBA': this node has my_msgs/srv/Move, \
                      std_msgs/msg/Header";
        assert_eq!(answer("std_msgs/msg/ColorRGBA", "", true), Err(unused.to_owned()));
        let hash = hash("std_msgs/msg/Header");
        let other = format!("type_hash is 'RIHS01_': expected {hash} for std_msgs/msg/Header");
        assert_eq!(answer("std_msgs/msg/Header", "RIHS01_", true), Err(other));
    }
}
