//! `type_description_interfaces/srv/GetTypeDescription`: what a type of a node looks like.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::{KeyValue, TypeDescription, TypeSource};
use crate::RosService;

/// The service that describes the types of a node's topics and services.
#[derive(Clone, Copy, Debug)]
pub struct GetTypeDescription;

impl RosService for GetTypeDescription {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "GetTypeDescription";
    type Request = Request;
    type Response = Response;
}

/// What a client asks of [`GetTypeDescription`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The full name of the type, such as `std_msgs/msg/Header`.
    pub type_name: String,
    /// The hash of its description, as [`TypeDescription::hash`] has it.
    pub type_hash: String,
    /// Whether the definitions are wanted, too.
    pub include_type_sources: bool,
}

impl Message for Request {}

/// What a node answers to [`GetTypeDescription`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Response {
    /// The description is here.
    pub successful: bool,
    /// Why not; empty on success.
    pub failure_reason: String,
    /// The description.
    pub type_description: TypeDescription,
    /// The definitions of the type and of each that it stands on, if they were asked for.
    pub type_sources: Vec<TypeSource>,
    /// Whatever else there is to say.
    pub extra_information: Vec<KeyValue>,
}

impl Message for Response {}
