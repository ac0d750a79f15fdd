//! What ROS builds from this directory is what Cargo builds, and the hashes are those of ROS.

use std::{fs, path::Path};

use evac_msgs::{DEFINITIONS, status};
use ros_interfaces::Interfaces;

/// The full name and the hash of each type, as rosidl 4.6 of ROS 2 Jazzy computes it:
/// rosidl_generator_type_description writes it to `evac_msgs/msg/TYPE.json`.
const HASHES_OF_ROS: &str = include_str!("type_hashes.txt");

#[test]
fn every_hash_is_that_of_ros() {
    let interfaces = Interfaces::with(DEFINITIONS).expect("the definitions are well-formed");
    let hashes = DEFINITIONS
        .iter()
        .map(|(name, _)| format!("{name} {}", interfaces.hash(name).expect("it is defined")));
    assert_eq!(hashes.collect::<Vec<_>>(), HASHES_OF_ROS.lines().collect::<Vec<_>>());
}

#[test]
fn a_service_stands_on_its_three_messages() {
    let interfaces = Interfaces::with(DEFINITIONS).expect("the definitions are well-formed");
    let description = interfaces.describe("evac_msgs/srv/Step").expect("it is defined");
    let fields = description.type_description.fields.iter();
    let fields: Vec<_> =
        fields.map(|f| (f.name.as_str(), f.r#type.nested_type_name.as_str())).collect();
    let expected = [
        ("request_message", "evac_msgs/srv/Step_Request"),
        ("response_message", "evac_msgs/srv/Step_Response"),
        ("event_message", "evac_msgs/srv/Step_Event"),
    ];
    assert_eq!(fields, expected);
    let referenced = description.referenced_type_descriptions.iter();
    let referenced: Vec<_> = referenced.map(|described| described.type_name.as_str()).collect();
    let expected = [
        "builtin_interfaces/msg/Time",
        "evac_msgs/srv/Step_Event",
        "evac_msgs/srv/Step_Request",
        "evac_msgs/srv/Step_Response",
        "sensor_msgs/msg/Image",
        "service_msgs/msg/ServiceEventInfo",
        "std_msgs/msg/Header",
    ];
    assert_eq!(referenced, expected);
    let sources = interfaces.sources("evac_msgs/srv/Step");
    let text = include_str!("../srv/Step.srv").trim_end();
    assert_eq!(
        (sources[0].encoding.as_str(), sources[0].raw_file_contents.as_str()),
        ("srv", text)
    );
    let implicit = sources.iter().filter(|source| source.encoding == "implicit");
    assert!(
        implicit.clone().count() == 3 && implicit.clone().all(|s| s.raw_file_contents.is_empty())
    );
}

/// A definition that is not in the list of CMakeLists.txt is one that other nodes do not have.
#[test]
fn ros_builds_every_definition() {
    let cmake = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("CMakeLists.txt"));
    let cmake = cmake.expect("CMakeLists.txt is there");
    let built: Vec<&str> =
        cmake.lines().filter_map(|line| line.trim().strip_prefix('"')?.strip_suffix('"')).collect();
    // evac_msgs/msg/QValues is msg/QValues.msg.
    let defined = DEFINITIONS.iter().map(|(name, _)| {
        let (_, path) = name.split_once('/').expect("a package");
        format!("{path}.{}", &path[..3])
    });
    assert_eq!(built, defined.collect::<Vec<_>>());
}

#[test]
fn a_status_is_called_what_the_definition_calls_it() {
    assert_eq!((status::name(0), status::name(8)), ("OK", "SUPERSEDED"));
    assert_eq!(status::name(9), "an unknown status");
}
