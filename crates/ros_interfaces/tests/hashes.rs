//! Compares type hashes, sources and default values with those of ROS 2 Jazzy.

use ros_interfaces::{
    DEFINITIONS, Interfaces, RosMessage, RosService,
    geometry_msgs::Quaternion,
    sensor_msgs::Image,
    type_description_interfaces::{
        GetTypeDescription, IndividualTypeDescription, get_type_description,
    },
};

/// The full name and type hash of every type in this crate, as computed by rosidl 4.6 (ROS 2
/// Jazzy): rosidl_generator_type_description writes the hash to `PACKAGE/msg/TYPE.json`.
const ROS_HASHES: &str = include_str!("type_hashes.txt");

fn interfaces() -> Interfaces {
    Interfaces::with(&[]).expect("the definitions are valid")
}

#[test]
fn type_hashes_match_ros() {
    let interfaces = interfaces();
    let mut hashes: Vec<String> = DEFINITIONS
        .iter()
        .map(|(name, _)| format!("{name} {}", interfaces.hash(name).expect("the type is defined")))
        .collect();
    hashes.sort();
    let mut expected: Vec<&str> = ROS_HASHES.lines().collect();
    expected.sort();
    assert_eq!(hashes, expected);
}

#[test]
fn sources_are_the_definitions_without_comments() {
    let sources = interfaces().sources(&Image::full_name());
    let names: Vec<&str> = sources.iter().map(|source| source.type_name.as_str()).collect();
    assert_eq!(
        names,
        ["sensor_msgs/msg/Image", "builtin_interfaces/msg/Time", "std_msgs/msg/Header"]
    );
    assert!(sources[0].raw_file_contents.starts_with("std_msgs/Header header\nuint32 height"));
}

#[test]
fn default_values_match_the_definitions() {
    let defaults = |full_name: &str| -> Vec<String> {
        let IndividualTypeDescription { fields, .. } =
            interfaces().describe(full_name).expect(full_name).type_description;
        fields.into_iter().map(|field| field.default_value).collect()
    };
    assert_eq!(defaults(&Quaternion::full_name()), ["0.0", "0.0", "0.0", "1.0"]);
    assert_eq!(Quaternion::default(), Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 });
    let request = format!("{}_Request", GetTypeDescription::full_name());
    assert_eq!(defaults(&request), ["", "", "True"]);
    assert!(get_type_description::Request::default().include_type_sources);
}

#[test]
fn an_undefined_type_has_no_description() {
    assert_eq!(interfaces().describe("std_msgs/msg/String"), None);
    assert_eq!(interfaces().describe("std_msgs/Header"), None);
}
