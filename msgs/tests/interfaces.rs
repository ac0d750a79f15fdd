//! The definitions in `msg/` and `srv/` and the Rust types say the same: the same fields under the
//! same names, in the same order, with the same types, and the same constants.
//!
//! CDR has no names on the wire, so two sides that disagree do not fail: they read nonsense.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use evac_msgs::{
    ActionCommand, EpisodeStatus, Header, Image, QValues, Reset, RosMessage, RosService, Step,
    Time, TrainingStatus,
    builtin_interfaces::Duration,
    diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue},
    geometry_msgs, nav_msgs,
    rosgraph_msgs::Clock,
    sensor_msgs, status,
    std_msgs::ColorRGBA,
    tf2_msgs::TFMessage,
    visualization_msgs,
    visualization_msgs::Marker,
};
use serde::de::DeserializeOwned;
use serde_reflection::{ContainerFormat, Format, Samples, Tracer, TracerConfig};

use standard::DEFINITIONS;

mod standard;

/// What a definition says of a message, or of one half of a service.
#[derive(Debug, Default, PartialEq)]
struct Definition {
    /// Name and value of each constant; every one of this package is an `uint8`.
    constants: BTreeMap<String, i32>,
    /// Type and name of each field.
    fields: Vec<(String, String)>,
}

impl Definition {
    /// Reads the lines of a `.msg` file or of one half of a `.srv` file.
    fn parse(text: &str) -> Self {
        let mut definition = Definition::default();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let (ros_type, rest) = line.split_once(' ').expect("a type and a name");
            // The same on the wire; Rust has no other name for it.
            let ros_type = if ros_type == "byte" { "uint8" } else { ros_type };
            match rest.split_once('=') {
                Some((name, value)) => {
                    let value = match ros_type {
                        "uint8" => value.trim().parse::<u8>().map(i32::from),
                        "int32" => value.trim().parse(),
                        _ => panic!("no constant here is of this type: {line}"),
                    };
                    let value = value.expect("a value of its type");
                    let name = name.trim().to_owned();
                    let earlier = definition.constants.insert(name, value);
                    assert_eq!(earlier, None, "defined twice: {line}");
                }
                None => definition.fields.push((ros_type.to_owned(), rest.trim().to_owned())),
            }
        }
        definition
    }
}

/// The fields of `T` as ROS would define them, and those of every type inside it, by the Rust name.
fn rust_fields<T: DeserializeOwned>() -> BTreeMap<String, Vec<(String, String)>> {
    let mut tracer = Tracer::new(TracerConfig::default());
    tracer.trace_type::<T>(&Samples::new()).expect("the type can be traced");
    let registry = tracer.registry().expect("the trace is complete");
    registry
        .into_iter()
        .map(|(name, container)| {
            let ContainerFormat::Struct(fields) = container else {
                panic!("{name} is not a struct with named fields: {container:?}");
            };
            let fields =
                fields.into_iter().map(|field| (ros_type(&field.value), field.name)).collect();
            (name, fields)
        })
        .collect()
}

/// The type of a Rust field as a `.msg` file writes it.
fn ros_type(format: &Format) -> String {
    match format {
        Format::Bool => "bool".to_owned(),
        Format::U8 => "uint8".to_owned(),
        Format::I32 => "int32".to_owned(),
        Format::U32 => "uint32".to_owned(),
        Format::U64 => "uint64".to_owned(),
        Format::F32 => "float32".to_owned(),
        Format::F64 => "float64".to_owned(),
        Format::Str => "string".to_owned(),
        Format::Seq(element) => format!("{}[]", ros_type(element)),
        Format::TupleArray { content, size } => match content.as_ref() {
            // A matrix is on the wire what its rows are, one after the other; ROS knows no matrices.
            Format::TupleArray { content, size: columns } => {
                format!("{}[{}]", ros_type(content), size * columns)
            }
            content => format!("{}[{size}]", ros_type(content)),
        },
        Format::TypeName(rust_name) => standard_name(rust_name).to_owned(),
        other => panic!("no ROS type is known for {other:?}"),
    }
}

/// The full ROS name of a standard type: serde knows it only by the name of its struct.
fn standard_name(rust_name: &str) -> &'static str {
    DEFINITIONS
        .iter()
        .map(|(full_name, _)| *full_name)
        .find(|full_name| full_name.ends_with(&format!("/{rust_name}")))
        .unwrap_or_else(|| panic!("{rust_name} is not one of the standard definitions"))
}

/// What ROS says of a standard type.
fn standard_definition(full_name: &str) -> Definition {
    let (_, text) = DEFINITIONS.into_iter().find(|(name, _)| *name == full_name).expect(full_name);
    Definition::parse(text)
}

/// Fails unless `T`, whose struct is called `rust_name`, has the fields of `definition`, and every
/// type inside it those of its standard definition.
fn assert_same_fields<T: DeserializeOwned>(what: &str, rust_name: &str, definition: &Definition) {
    let mut containers = rust_fields::<T>();
    let fields = containers
        .remove(rust_name)
        .unwrap_or_else(|| panic!("{what}: the Rust type is not called {rust_name}"));
    assert_eq!(fields, definition.fields, "{what}: Rust left, ROS right");
    for (inner, fields) in containers {
        let full_name = standard_name(&inner);
        let expected = standard_definition(full_name);
        assert_eq!(fields, expected.fields, "{full_name}: Rust left, ROS right");
    }
}

/// The constants of a Rust type or module, under the names that the ROS definition gives them.
macro_rules! constants {
    ($owner:ident: $($name:ident),* $(,)?) => {
        BTreeMap::from([$((stringify!($name).to_owned(), i32::from($owner::$name))),*])
    };
}

/// The directory of this package, where `msg/` and `srv/` are.
fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Compares the definition in `msg/` with the Rust type `T`.
fn assert_message<T: RosMessage>(constants: BTreeMap<String, i32>) {
    assert_eq!(T::PACKAGE, "evac_msgs");
    let file = format!("msg/{}.msg", T::NAME);
    let text = fs::read_to_string(package().join(&file)).expect(&file);
    let definition = Definition::parse(&text);
    assert_same_fields::<T>(&file, T::NAME, &definition);
    assert_eq!(constants, definition.constants, "{file}: Rust left");
}

/// Compares the definition in `srv/` with the request and the response of `S`.
fn assert_service<S: RosService>() {
    assert_eq!(S::PACKAGE, "evac_msgs");
    let file = format!("srv/{}.srv", S::NAME);
    let text = fs::read_to_string(package().join(&file)).expect(&file);
    let halves: Vec<&str> = text.split("\n---\n").collect();
    let [request, response] = halves[..] else {
        panic!("{file}: a request, a line of three dashes, a response");
    };
    let (request, response) = (Definition::parse(request), Definition::parse(response));
    assert_same_fields::<S::Request>(&format!("{file}, request"), "Request", &request);
    assert_same_fields::<S::Response>(&format!("{file}, response"), "Response", &response);
    assert_eq!(request.constants, BTreeMap::new(), "{file}, request");
    assert_eq!(status_constants(), response.constants, "{file}, response: Rust left");
}

fn status_constants() -> BTreeMap<String, i32> {
    constants!(status: OK, INVALID_ACTION, UNKNOWN_EPISODE, SIMULATOR_RESTARTED, OUT_OF_ORDER,
        ACTION_DIFFERS, EPISODE_OVER, INVALID_SCENARIO, SUPERSEDED)
}

/// Every file below `directory` with this extension.
fn files_below(directory: &Path, extension: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(directory).expect("the directory can be listed") {
        let path = entry.expect("the entry can be read").path();
        if path.is_dir() {
            files.extend(files_below(&path, extension));
        } else if path.extension().is_some_and(|found| found == extension) {
            files.push(path);
        }
    }
    files.sort();
    files
}

#[test]
fn action_command_is_its_definition() {
    assert_message::<ActionCommand>(constants!(ActionCommand: TURN_RIGHT_135, TURN_RIGHT_90,
        TURN_RIGHT_45, FORWARD, TURN_LEFT_45, TURN_LEFT_90, TURN_LEFT_135));
}

#[test]
fn episode_status_is_its_definition() {
    assert_message::<EpisodeStatus>(constants!(EpisodeStatus: NONE));
}

#[test]
fn q_values_is_its_definition() {
    assert_message::<QValues>(BTreeMap::new());
}

#[test]
fn training_status_is_its_definition() {
    assert_message::<TrainingStatus>(BTreeMap::new());
}

#[test]
fn reset_is_its_definition() {
    assert_service::<Reset>();
}

#[test]
fn step_is_its_definition() {
    assert_service::<Step>();
}

/// Compares a standard definition with the Rust type `T`: its name.
fn assert_standard<T: RosMessage>(constants: BTreeMap<String, i32>) -> String {
    let full_name = format!("{}/{}", T::PACKAGE, T::NAME);
    let definition = standard_definition(&full_name);
    assert_same_fields::<T>(&full_name, T::NAME, &definition);
    assert_eq!(constants, definition.constants, "{full_name}: Rust left, ROS right");
    full_name
}

#[test]
fn standard_types_are_those_of_ros() {
    fn plain<T: RosMessage>() -> String {
        assert_standard::<T>(BTreeMap::new())
    }
    let compared = [
        plain::<Duration>(),
        plain::<Time>(),
        plain::<DiagnosticArray>(),
        assert_standard::<DiagnosticStatus>(constants!(DiagnosticStatus: OK, WARN, ERROR, STALE)),
        plain::<KeyValue>(),
        plain::<geometry_msgs::Point>(),
        plain::<geometry_msgs::Pose>(),
        plain::<geometry_msgs::PoseStamped>(),
        plain::<geometry_msgs::PoseWithCovariance>(),
        plain::<geometry_msgs::Quaternion>(),
        plain::<geometry_msgs::Transform>(),
        plain::<geometry_msgs::TransformStamped>(),
        plain::<geometry_msgs::Twist>(),
        plain::<geometry_msgs::TwistWithCovariance>(),
        plain::<geometry_msgs::Vector3>(),
        plain::<nav_msgs::Odometry>(),
        plain::<nav_msgs::Path>(),
        plain::<Clock>(),
        plain::<sensor_msgs::CameraInfo>(),
        plain::<sensor_msgs::CompressedImage>(),
        plain::<Image>(),
        plain::<sensor_msgs::RegionOfInterest>(),
        plain::<ColorRGBA>(),
        plain::<Header>(),
        plain::<TFMessage>(),
        assert_standard::<Marker>(constants!(Marker: ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP,
            LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TEXT_VIEW_FACING, MESH_RESOURCE,
            TRIANGLE_LIST, ARROW_STRIP, ADD, MODIFY, DELETE, DELETEALL)),
        plain::<visualization_msgs::MarkerArray>(),
        plain::<visualization_msgs::MeshFile>(),
        plain::<visualization_msgs::UVCoordinate>(),
    ];
    assert_eq!(compared, DEFINITIONS.map(|(name, _)| name), "compared left, defined right");
}

/// As in ROS, where a quaternion of four zeros would be no rotation at all.
#[test]
fn a_pose_that_nobody_turned_is_not_turned() {
    let pose = geometry_msgs::Pose::default();
    assert_eq!(pose.orientation, geometry_msgs::Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 });
}

/// The definitions, the Rust types and the list in CMakeLists.txt are the same set, and so are the
/// types that the tests above compare: one that is new anywhere must be new everywhere.
#[test]
fn every_definition_has_its_rust_type_and_is_built() {
    let messages = [ActionCommand::NAME, EpisodeStatus::NAME, QValues::NAME, TrainingStatus::NAME];
    let services = [Reset::NAME, Step::NAME];
    let mut tested: Vec<String> = messages
        .iter()
        .map(|name| format!("msg/{name}.msg"))
        .chain(services.iter().map(|name| format!("srv/{name}.srv")))
        .collect();
    tested.sort();

    let mut defined = Vec::new();
    for extension in ["msg", "srv"] {
        for path in files_below(&package().join(extension), extension) {
            let relative = path.strip_prefix(package()).unwrap();
            defined.push(relative.to_str().unwrap().to_owned());
        }
    }
    defined.sort();
    assert_eq!(tested, defined, "Rust types left, files right");

    let cmake = fs::read_to_string(package().join("CMakeLists.txt")).unwrap();
    let mut built: Vec<&str> =
        cmake.lines().filter_map(|line| line.trim().strip_prefix('"')?.strip_suffix('"')).collect();
    built.sort_unstable();
    assert_eq!(built, defined, "CMakeLists.txt left, files right");

    // No list of a crate's types exists at run time, so the sources are read for theirs.
    let mut implemented = Vec::new();
    for path in files_below(&package().join("src"), "rs") {
        for line in fs::read_to_string(path).unwrap().lines() {
            for (kind, introduction) in
                [("msg", "impl RosMessage for "), ("srv", "impl RosService for ")]
            {
                if let Some(name) = line.strip_prefix(introduction) {
                    let name = name.trim_end_matches(" {");
                    implemented.push(format!("{kind}/{name}.{kind}"));
                }
            }
        }
    }
    let standard = DEFINITIONS.map(|(name, _)| {
        let (_, name) = name.split_once('/').unwrap();
        format!("msg/{name}.msg")
    });
    implemented.retain(|name| !standard.contains(name));
    implemented.sort();
    assert_eq!(implemented, defined, "sources left, files right");
}

#[test]
fn status_name_knows_every_constant_and_nothing_else() {
    let named: BTreeMap<String, i32> = (0..=u8::MAX)
        .filter(|value| status::name(*value) != "an unknown status")
        .map(|value| (status::name(value).to_owned(), i32::from(value)))
        .collect();
    assert_eq!(named, status_constants());
}
