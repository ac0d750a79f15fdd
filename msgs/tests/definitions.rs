//! Checks that ROS and Cargo build the same definitions with the same type hashes.

use std::{fs, path::Path};

use evac_msgs::{DEFINITIONS, status};
use ros_interfaces::Interfaces;

/// The full name and type hash of every type, as computed by rosidl 4.6 (ROS 2 Jazzy):
/// rosidl_generator_type_description writes the hash to `evac_msgs/msg/TYPE.json`.
const ROS_HASHES: &str = include_str!("type_hashes.txt");

#[test]
fn type_hashes_match_ros() {
    let interfaces = Interfaces::with(DEFINITIONS).expect("the definitions are valid");
    let hashes = DEFINITIONS
        .iter()
        .map(|(name, _)| format!("{name} {}", interfaces.hash(name).expect("the type is defined")));
    assert_eq!(hashes.collect::<Vec<_>>(), ROS_HASHES.lines().collect::<Vec<_>>());
}

#[test]
fn a_service_references_its_three_messages() {
    let interfaces = Interfaces::with(DEFINITIONS).expect("the definitions are valid");
    let description = interfaces.describe("evac_msgs/srv/Step").expect("the type is defined");
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

/// ROS 2 builds only the definitions listed in CMakeLists.txt.
#[test]
fn cmake_lists_every_definition() {
    let cmake = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("CMakeLists.txt"));
    let cmake = cmake.expect("CMakeLists.txt exists");
    let built: Vec<&str> =
        cmake.lines().filter_map(|line| line.trim().strip_prefix('"')?.strip_suffix('"')).collect();
    // For example, evac_msgs/msg/QValues is defined in msg/QValues.msg.
    let defined = DEFINITIONS.iter().map(|(name, _)| {
        let (_, path) = name.split_once('/').expect("the name starts with a package");
        format!("{path}.{}", &path[..3])
    });
    assert_eq!(built, defined.collect::<Vec<_>>());
}

#[test]
fn status_names_match_the_definitions() {
    assert_eq!((status::name(0), status::name(8)), ("OK", "SUPERSEDED"));
    assert_eq!(status::name(9), "unknown status");
}
