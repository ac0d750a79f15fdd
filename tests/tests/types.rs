//! Checks the service `get_type_description` of a node over DDS.

use evac_msgs::{EpisodeStatus, QValues, Reset, Step};
use evac_tests::{Nodes, TIMEOUT, interfaces};
use ros_interfaces::{
    RosMessage, RosService,
    sensor_msgs::Image,
    type_description_interfaces::{
        GetTypeDescription,
        get_type_description::{Request, Response},
    },
};
use ros_runtime::{Node, service::ServiceClient};

/// A client of the simulator's service `get_type_description`.
struct Client {
    node: Node,
    service: ServiceClient<GetTypeDescription>,
}

impl Client {
    fn new(nodes: &Nodes) -> Client {
        let mut node = nodes.client();
        let service = node.create_client("sim_node/get_type_description").expect("a client");
        Client { node, service }
    }

    fn call(&self, type_name: String, type_hash: &str, include_type_sources: bool) -> Response {
        let request = Request { type_name, type_hash: type_hash.to_owned(), include_type_sources };
        self.node.block_on(self.service.call(request, Some(TIMEOUT))).expect("a response")
    }
}

#[test]
fn a_node_describes_exactly_the_types_it_uses() {
    /// From `crates/ros_interfaces/tests/type_hashes.txt`, as computed by ROS 2.
    const HASH_OF_IMAGE: &str =
        "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47";
    let mut nodes = Nodes::new();
    nodes.start_simulator(&[]);
    let client = Client::new(&nodes);

    let image = client.call(Image::full_name(), HASH_OF_IMAGE, true);
    assert!(image.successful, "{}", image.failure_reason);
    assert_eq!(image.type_description.type_description.type_name, "sensor_msgs/msg/Image");
    let types = interfaces();
    assert_eq!(Some(image.type_description), types.describe(&Image::full_name()));
    let sources = image.type_sources.iter().map(|source| source.type_name.as_str());
    let expected = ["sensor_msgs/msg/Image", "builtin_interfaces/msg/Time", "std_msgs/msg/Header"];
    assert_eq!(sources.collect::<Vec<_>>(), expected);

    // Types of the simulator's own topics and services, and of those that every node has.
    let names = [
        EpisodeStatus::full_name(),
        Reset::full_name(),
        Step::full_name(),
        GetTypeDescription::full_name(),
        "rcl_interfaces/srv/SetParameters".to_owned(),
        "rcl_interfaces/msg/Log".to_owned(),
    ];
    for name in names {
        let description = types.describe(&name).expect("a definition");
        let hash = types.hash(&name).expect("a definition");
        let response = client.call(name, &hash, false);
        assert!(response.successful, "{}", response.failure_reason);
        assert_eq!((response.type_description, response.type_sources), (description, vec![]));
    }

    // A type that only the agent uses, and a type with the hash of another definition.
    let other_hash = types.hash(&QValues::full_name()).expect("a definition");
    let unused = client.call(QValues::full_name(), &other_hash, true);
    assert!(!unused.successful);
    let reason = "unknown type 'evac_msgs/msg/QValues' (expected: ";
    assert!(unused.failure_reason.starts_with(reason), "{}", unused.failure_reason);
    assert_eq!((unused.type_description, unused.type_sources), Default::default());
    let mismatched = client.call(Image::full_name(), &other_hash, true);
    let reason =
        format!("type_hash is '{other_hash}': expected {HASH_OF_IMAGE} for sensor_msgs/msg/Image");
    assert_eq!((mismatched.successful, mismatched.failure_reason), (false, reason));
}

#[test]
fn the_service_can_be_disabled() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&["start_type_description_service:=false"]);
    let client = Client::new(&nodes);
    // A response from another service shows that discovery is complete.
    let mut node = nodes.client();
    let reset = node.create_client::<Reset>("reset").expect("a client");
    node.block_on(reset.call(Default::default(), Some(TIMEOUT))).expect("a response");
    assert_eq!(client.service.servers(), 0);
}
