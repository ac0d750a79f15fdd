//! Descriptions and hashes of types are those of ROS 2 Jazzy.

use evac_msgs::{
    Image, RosMessage, RosService, Step,
    definition::definitions,
    geometry_msgs::Quaternion,
    type_description_interfaces::{GetTypeDescription, TypeDescription, TypeSource},
};

/// The full name and the hash of every type that is defined here, as rosidl 4.6 of ROS 2 Jazzy
/// computes it for the package, ours included: rosidl_generate_interfaces runs
/// rosidl_generator_type_description, which writes it to `type_hashes` in `PACKAGE/msg/TYPE.json`.
const HASHES_OF_ROS: &str = include_str!("type_hashes.txt");

fn described(full_name: &str) -> TypeDescription {
    TypeDescription::of(full_name).unwrap_or_else(|| panic!("no description of {full_name}"))
}

#[test]
fn every_hash_is_that_of_ros() {
    let hashes = definitions().map(|(name, _)| format!("{name} {}", described(name).hash()));
    let expected: Vec<&str> = HASHES_OF_ROS.lines().collect();
    assert_eq!(hashes.collect::<Vec<_>>(), expected);
}

#[test]
fn a_service_stands_on_its_three_messages() {
    let description = described(&Step::full_name());
    let fields = description.type_description.fields.iter();
    let fields: Vec<_> = fields.map(|f| (f.name.as_str(), &f.r#type.nested_type_name)).collect();
    let message = |suffix| format!("evac_msgs/srv/Step_{suffix}");
    let expected = [
        ("request_message", &message("Request")),
        ("response_message", &message("Response")),
        ("event_message", &message("Event")),
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
}

#[test]
fn sources_are_the_definitions() {
    let sources = described(&Step::full_name()).sources();
    let encodings = |encoding: &str| sources.iter().filter(|s| s.encoding == encoding).count();
    assert_eq!(
        (encodings(TypeSource::SRV), encodings(TypeSource::MSG), encodings(TypeSource::IMPLICIT)),
        (1, 4, 3)
    );
    assert_eq!(sources[0].type_name, "evac_msgs/srv/Step");
    assert_eq!(sources[0].raw_file_contents, include_str!("../srv/Step.srv").trim_end());
    let implicit = sources.iter().find(|source| source.encoding == TypeSource::IMPLICIT);
    assert_eq!(implicit.map(|source| source.raw_file_contents.as_str()), Some(""));
    assert_eq!(described(&Image::full_name()).sources().len(), 3);
}

#[test]
fn default_values_are_described_as_python_writes_them() {
    let defaults = |full_name: &str| -> Vec<String> {
        let fields = described(full_name).type_description.fields.into_iter();
        fields.map(|field| field.default_value).collect()
    };
    assert_eq!(defaults(&Quaternion::full_name()), ["0.0", "0.0", "0.0", "1.0"]);
    let request = format!("{}_Request", GetTypeDescription::full_name());
    assert_eq!(defaults(&request), ["", "", "True"]);
}

#[test]
fn what_is_not_defined_here_is_not_described() {
    assert_eq!(TypeDescription::of("std_msgs/msg/String"), None);
    assert_eq!(TypeDescription::of("std_msgs/Header"), None);
}
