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
    definition::{Definition, definitions},
    diagnostic_msgs::{self, DiagnosticArray, DiagnosticStatus},
    geometry_msgs, nav_msgs,
    rosgraph_msgs::Clock,
    sensor_msgs, status,
    std_msgs::ColorRGBA,
    tf2_msgs::TFMessage,
    type_description_interfaces::{
        self, Field, FieldType, GetTypeDescription, IndividualTypeDescription, TypeDescription,
    },
    visualization_msgs,
    visualization_msgs::Marker,
};
use serde::de::DeserializeOwned;
use serde_reflection::{ContainerFormat, Format, Samples, Tracer, TracerConfig};

/// The packages whose messages are types of ros2-client, or are never sent.
const WITHOUT_RUST_TYPES: [&str; 3] = ["rcl_interfaces", "service_msgs", "rmw_dds_common"];

/// Name and type of each field.
type Fields = Vec<(String, FieldType)>;

/// What a definition says of its constants: those of each part, a message or one half of a service.
fn defined_constants(full_name: &str) -> Vec<BTreeMap<String, i32>> {
    let (_, text) = definitions().find(|(name, _)| *name == full_name).expect(full_name);
    let parts = Definition::parse("", text).into_iter();
    parts
        .map(|part| {
            let mut constants = BTreeMap::new();
            for (name, value) in part.constants {
                let value = value.parse().expect("every constant here is a whole number");
                assert_eq!(constants.insert(name, value), None, "defined twice in {full_name}");
            }
            constants
        })
        .collect()
}

/// The fields of `T`, and those of every type inside it, by the Rust name.
fn rust_fields<T: DeserializeOwned>() -> BTreeMap<String, Vec<(String, Format)>> {
    let mut tracer = Tracer::new(TracerConfig::default());
    tracer.trace_type::<T>(&Samples::new()).expect("the type can be traced");
    let registry = tracer.registry().expect("the trace is complete");
    let fields = |(name, container)| {
        let ContainerFormat::Struct(fields) = container else {
            panic!("{name} is not a struct with named fields: {container:?}");
        };
        (name, fields.into_iter().map(|field| (field.name, field.value)).collect())
    };
    registry.into_iter().map(fields).collect()
}

/// The type of a Rust field as ROS describes it; `full_name` gives the full name of a Rust type.
fn ros_type(format: &Format, full_name: &impl Fn(&str) -> String) -> FieldType {
    let plain = |type_id| FieldType { type_id, ..Default::default() };
    match format {
        Format::Bool => plain(FieldType::FIELD_TYPE_BOOLEAN),
        Format::U8 => plain(FieldType::FIELD_TYPE_UINT8),
        Format::I32 => plain(FieldType::FIELD_TYPE_INT32),
        Format::U32 => plain(FieldType::FIELD_TYPE_UINT32),
        Format::U64 => plain(FieldType::FIELD_TYPE_UINT64),
        Format::F32 => plain(FieldType::FIELD_TYPE_FLOAT),
        Format::F64 => plain(FieldType::FIELD_TYPE_DOUBLE),
        Format::Str => plain(FieldType::FIELD_TYPE_STRING),
        Format::Seq(element) => {
            let element = ros_type(element, full_name);
            FieldType { type_id: element.type_id + FieldType::UNBOUNDED_SEQUENCE, ..element }
        }
        Format::TupleArray { content, size } => {
            // A matrix is on the wire what its rows are, one after the other; ROS knows no matrices.
            let (element, size) = match content.as_ref() {
                Format::TupleArray { content, size: columns } => (content, size * columns),
                _ => (content, *size),
            };
            let element = ros_type(element, full_name);
            let type_id = element.type_id + FieldType::ARRAY;
            FieldType { type_id, capacity: size as u64, ..element }
        }
        Format::TypeName(rust_name) => FieldType {
            nested_type_name: full_name(rust_name),
            ..plain(FieldType::FIELD_TYPE_NESTED_TYPE)
        },
        other => panic!("no ROS type is known for {other:?}"),
    }
}

/// The fields of a description, without what CDR and Rust do not tell apart.
fn described_fields(fields: &[Field]) -> Fields {
    let field = |field: &Field| {
        let mut described = field.r#type.clone();
        described.string_capacity = 0;
        described.type_id = match described.type_id {
            FieldType::FIELD_TYPE_BYTE => FieldType::FIELD_TYPE_UINT8,
            FieldType::FIELD_TYPE_BOUNDED_STRING => FieldType::FIELD_TYPE_STRING,
            other => other,
        };
        (field.name.clone(), described)
    };
    fields.iter().map(field).collect()
}

/// What Rust calls a type with this full name, such as `std_msgs/msg/Header` or
/// `evac_msgs/srv/Step_Request`.
fn rust_name(full_name: &str) -> &str {
    full_name.rsplit(['/', '_']).next().unwrap_or_default()
}

/// Fails unless `T` and every type inside it have the fields of their definitions.
fn assert_same_fields<T: DeserializeOwned>(full_name: &str) {
    let description = TypeDescription::of(full_name).expect(full_name);
    let TypeDescription { type_description, mut referenced_type_descriptions } = description;
    referenced_type_descriptions.push(type_description);
    let types: BTreeMap<&str, &IndividualTypeDescription> =
        referenced_type_descriptions.iter().map(|t| (rust_name(&t.type_name), t)).collect();
    let name_of = |rust_name: &str| match types.get(rust_name) {
        Some(described) => described.type_name.clone(),
        None => panic!("{full_name} has no {rust_name} in it"),
    };
    let containers = rust_fields::<T>();
    assert!(containers.keys().eq(types.keys()), "{full_name}: {:?}", containers.keys());
    for (rust_name, fields) in containers {
        let fields = fields.into_iter().map(|(name, format)| (name, ros_type(&format, &name_of)));
        let described = types[rust_name.as_str()];
        let expected = described_fields(&described.fields);
        let name = &described.type_name;
        assert_eq!(fields.collect::<Fields>(), expected, "{name}: Rust left, ROS right");
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

/// Compares a definition with the Rust type `T`: its name.
fn assert_message<T: RosMessage>(constants: BTreeMap<String, i32>) -> String {
    let name = T::full_name();
    assert_same_fields::<T>(&name);
    assert_eq!([constants][..], defined_constants(&name), "{name}: Rust left, ROS right");
    name
}

/// Compares a definition with the request and the response of `S`: its name.
fn assert_service<S: RosService>(response_constants: BTreeMap<String, i32>) -> String {
    let name = S::full_name();
    assert_same_fields::<S::Request>(&format!("{name}_Request"));
    assert_same_fields::<S::Response>(&format!("{name}_Response"));
    let constants = [BTreeMap::new(), response_constants];
    assert_eq!(constants[..], defined_constants(&name), "{name}: Rust left, ROS right");
    name
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
    assert_service::<Reset>(status_constants());
}

#[test]
fn step_is_its_definition() {
    assert_service::<Step>(status_constants());
}

/// The constants of a type, and those that ROS has for arrays and sequences of it.
fn field_type_constants() -> BTreeMap<String, i32> {
    let mut constants = constants!(FieldType: FIELD_TYPE_NESTED_TYPE, FIELD_TYPE_INT8,
        FIELD_TYPE_UINT8, FIELD_TYPE_INT16, FIELD_TYPE_UINT16, FIELD_TYPE_INT32, FIELD_TYPE_UINT32,
        FIELD_TYPE_INT64, FIELD_TYPE_UINT64, FIELD_TYPE_FLOAT, FIELD_TYPE_DOUBLE,
        FIELD_TYPE_LONG_DOUBLE, FIELD_TYPE_CHAR, FIELD_TYPE_WCHAR, FIELD_TYPE_BOOLEAN,
        FIELD_TYPE_BYTE, FIELD_TYPE_STRING, FIELD_TYPE_WSTRING, FIELD_TYPE_FIXED_STRING,
        FIELD_TYPE_FIXED_WSTRING, FIELD_TYPE_BOUNDED_STRING, FIELD_TYPE_BOUNDED_WSTRING);
    let sums = constants!(FieldType: ARRAY, BOUNDED_SEQUENCE, UNBOUNDED_SEQUENCE);
    for (name, value) in constants.clone() {
        for (suffix, offset) in &sums {
            constants.insert(format!("{name}_{suffix}"), value + offset);
        }
    }
    constants.extend(constants!(FieldType: FIELD_TYPE_NOT_SET));
    constants
}

#[test]
fn standard_types_are_those_of_ros() {
    fn plain<T: RosMessage>() -> String {
        assert_message::<T>(BTreeMap::new())
    }
    let compared = [
        plain::<Duration>(),
        plain::<Time>(),
        plain::<DiagnosticArray>(),
        assert_message::<DiagnosticStatus>(constants!(DiagnosticStatus: OK, WARN, ERROR, STALE)),
        plain::<diagnostic_msgs::KeyValue>(),
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
        plain::<type_description_interfaces::Field>(),
        assert_message::<FieldType>(field_type_constants()),
        plain::<IndividualTypeDescription>(),
        plain::<type_description_interfaces::KeyValue>(),
        plain::<TypeDescription>(),
        plain::<type_description_interfaces::TypeSource>(),
        assert_service::<GetTypeDescription>(BTreeMap::new()),
        assert_message::<Marker>(constants!(Marker: ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP,
            LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TEXT_VIEW_FACING, MESH_RESOURCE,
            TRIANGLE_LIST, ARROW_STRIP, ADD, MODIFY, DELETE, DELETEALL)),
        plain::<visualization_msgs::MarkerArray>(),
        plain::<visualization_msgs::MeshFile>(),
        plain::<visualization_msgs::UVCoordinate>(),
    ];
    let package = |name: &str| name.split('/').next().map(str::to_owned).unwrap_or_default();
    let standard = definitions().map(|(name, _)| name).filter(|name| {
        let package = package(name);
        package != "evac_msgs" && !WITHOUT_RUST_TYPES.contains(&package.as_str())
    });
    assert_eq!(compared, standard.collect::<Vec<_>>()[..], "compared left, defined right");
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
    let names = [
        ActionCommand::full_name(),
        EpisodeStatus::full_name(),
        QValues::full_name(),
        TrainingStatus::full_name(),
        Reset::full_name(),
        Step::full_name(),
    ];
    // As files: msg/ActionCommand.msg.
    let file = |name: &str| {
        let (_, path) = name.split_once('/').unwrap();
        format!("{path}.{}", &path[..3])
    };
    let tested = names.map(|name| file(&name));

    let mut defined = Vec::new();
    for extension in ["msg", "srv"] {
        for path in files_below(&package().join(extension), extension) {
            let relative = path.strip_prefix(package()).unwrap();
            defined.push(relative.to_str().unwrap().to_owned());
        }
    }
    assert_eq!(tested, defined[..], "Rust types left, files right");

    let (own, standard): (Vec<_>, Vec<_>) =
        definitions().map(|(name, _)| name).partition(|name| name.starts_with("evac_msgs/"));
    assert_eq!(own.into_iter().map(file).collect::<Vec<_>>(), defined, "text left, files right");

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
    let standard: Vec<String> = standard.into_iter().map(file).collect();
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
