//! Compares the serialization of every message with that of an independent encoder.
//!
//! `tests/peers/cdr_encoder.py` reads the definitions in `msgs/msg` and `msgs/srv` and encodes the
//! same values with Python's `rosbags`, which shares no code with rustdds. Equal bytes show that
//! other ROS 2 nodes, which use the same definitions, decode our messages correctly.

use std::fmt::Debug;
use std::path::Path;
use std::process::{Command, Stdio};

use evac_msgs::{
    ActionCommand, EpisodeStatus, QValues, Reset, Step, TrainingStatus, reset, status, step,
};
use evac_tests::interfaces;
use ros_interfaces::{
    RosMessage, RosService, builtin_interfaces::Time, nav_msgs::Odometry, sensor_msgs::CameraInfo,
    sensor_msgs::Image, std_msgs::Header, type_description_interfaces::TypeDescription,
    visualization_msgs::Marker,
};
use rustdds::RepresentationIdentifier;
use rustdds::serialization::{deserialize_from_cdr_with_rep_id, to_writer_with_rep_id};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// The encapsulation header of a sample: little-endian CDR, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A value to encode: the request to the peer, and the bytes that rustdds sends.
struct Case {
    request: Value,
    bytes: Vec<u8>,
}

impl Case {
    /// Encodes a value with rustdds and checks that the bytes decode to the same value.
    fn new<T>(ros_type: &str, value: &T) -> Self
    where
        T: Serialize + DeserializeOwned + PartialEq + Debug,
    {
        const ENCODING: RepresentationIdentifier = RepresentationIdentifier::CDR_LE;
        let mut encoded = Vec::new();
        to_writer_with_rep_id(&mut encoded, value, ENCODING).expect("the value is encoded");
        let (decoded, consumed) = deserialize_from_cdr_with_rep_id::<T>(&encoded, ENCODING)
            .expect("the value is decoded");
        assert_eq!((&decoded, consumed), (value, encoded.len()));
        Case {
            request: json!({ "type": ros_type, "value": value }),
            bytes: [&ENCAPSULATION[..], &encoded].concat(),
        }
    }
}

fn message_cases<T: RosMessage + PartialEq + Debug>(values: &[T]) -> Vec<Case> {
    values.iter().map(|v| Case::new(&T::full_name(), v)).collect()
}

fn service_cases<S: RosService>(requests: &[S::Request], responses: &[S::Response]) -> Vec<Case>
where
    S::Request: PartialEq + Debug,
    S::Response: PartialEq + Debug,
{
    let ros_type = S::full_name();
    let (request, response) = (format!("{ros_type}_Request"), format!("{ros_type}_Response"));
    let requests = requests.iter().map(|v| Case::new(&request, v));
    let responses = responses.iter().map(|v| Case::new(&response, v));
    requests.chain(responses).collect()
}

/// Returns strings of every length modulo eight, since the padding after a string depends on its
/// length; two of them are not ASCII.
fn strings() -> Vec<String> {
    let ascii = (0..=8).map(|length| "camera_o"[..length].to_owned());
    ascii.chain(["sortie à côté".to_owned(), "出口".to_owned()]).collect()
}

/// Returns a time with extreme field values, time zero, and the latest valid time.
fn times() -> [Time; 3] {
    let latest = Time { sec: i32::MAX, nanosec: 999_999_999 };
    let earliest = Time { sec: i32::MIN, nanosec: u32::MAX };
    [earliest, Time::default(), latest]
}

fn headers() -> Vec<Header> {
    let frames = strings().into_iter().zip(times().into_iter().cycle());
    frames.map(|(frame_id, stamp)| Header { stamp, frame_id }).collect()
}

/// Returns a camera image, 20 x 7 pixels of three bytes, that contains every byte value.
fn camera_image(header: Header) -> Image {
    Image {
        header,
        height: 7,
        width: 20,
        encoding: "rgb8".to_owned(),
        is_bigendian: 0,
        step: 60,
        data: (0..=u8::MAX).cycle().take(420).collect(),
    }
}

/// Returns an empty image, one with the largest field values, and a camera image for each header.
fn images() -> Vec<Image> {
    let largest = Image {
        header: Header::default(),
        height: u32::MAX,
        width: u32::MAX,
        encoding: "mono16".to_owned(),
        is_bigendian: u8::MAX,
        step: u32::MAX,
        data: vec![u8::MAX],
    };
    let frames = headers().into_iter().map(camera_image);
    [Image::default(), largest].into_iter().chain(frames).collect()
}

fn action_commands() -> Vec<ActionCommand> {
    let actions = [ActionCommand::TURN_RIGHT_135, ActionCommand::FORWARD, u8::MAX];
    let commands = headers().into_iter().zip(actions.into_iter().cycle());
    commands
        .map(|(header, action)| ActionCommand {
            header,
            action,
            sent_by_service: action == ActionCommand::FORWARD,
        })
        .collect()
}

fn episode_statuses() -> Vec<EpisodeStatus> {
    let filled = headers().into_iter().flat_map(|header| {
        strings().into_iter().map(move |scenario| EpisodeStatus {
            header: header.clone(),
            episode: u64::MAX - 1,
            scenario,
            seed: u64::MAX,
            step: 10_000,
            action: EpisodeStatus::NONE,
            reward: -0.1,
            terminated: true,
            truncated: false,
            blocked: true,
        })
    });
    [EpisodeStatus::default()].into_iter().chain(filled).collect()
}

fn q_values() -> Vec<QValues> {
    let values = [0.0, -0.0, -0.1, f32::MAX, f32::MIN, f32::MIN_POSITIVE, f32::EPSILON];
    let filled =
        headers().into_iter().map(|header| QValues { header, values, action: 6, explored: true });
    [QValues::default()].into_iter().chain(filled).collect()
}

fn training_statuses() -> Vec<TrainingStatus> {
    let filled = headers().into_iter().map(|header| TrainingStatus {
        header,
        episode: 999,
        episodes: 1000,
        steps: u32::MAX,
        total_steps: u64::MAX,
        episode_return: -999.9,
        epsilon: 0.1,
        loss: f32::MIN_POSITIVE,
        steps_per_s: 1234.5,
        success_rate: 1.0,
    });
    [TrainingStatus::default()].into_iter().chain(filled).collect()
}

fn type_descriptions() -> Vec<TypeDescription> {
    let names = [Time::full_name(), QValues::full_name(), Step::full_name()];
    let described = names.iter().map(|name| interfaces().describe(name).expect("a definition"));
    [TypeDescription::default()].into_iter().chain(described).collect()
}

fn odometry() -> Odometry {
    let mut odometry = Odometry::default();
    for (index, value) in odometry.pose.covariance.iter_mut().enumerate() {
        *value = index as f64;
    }
    odometry
}

fn reset_requests() -> Vec<reset::Request> {
    let requests = strings().into_iter().map(|scenario| reset::Request {
        request: u64::MAX,
        seed: u64::MAX - 1,
        scenario,
    });
    requests.collect()
}

fn reset_responses() -> Vec<reset::Response> {
    let refused = strings().into_iter().map(|message| reset::Response {
        success: false,
        status: status::INVALID_SCENARIO,
        message,
        episode: u64::MAX,
        image: Image::default(),
    });
    let accepted = images().into_iter().map(|image| reset::Response {
        success: true,
        status: status::OK,
        message: String::new(),
        episode: 1,
        image,
    });
    refused.chain(accepted).collect()
}

fn step_requests() -> Vec<step::Request> {
    let largest = step::Request { episode: u64::MAX, step: u32::MAX, action: u8::MAX };
    vec![step::Request::default(), largest]
}

fn step_responses() -> Vec<step::Response> {
    let refused = strings().into_iter().map(|message| step::Response {
        status: status::SUPERSEDED,
        message,
        ..step::Response::default()
    });
    // The padding after the image depends on the length of its data.
    let accepted = (0..=8).chain([420]).map(|length| step::Response {
        success: true,
        status: status::OK,
        message: String::new(),
        image: Image { data: vec![7; length], ..camera_image(Header::default()) },
        reward: -0.1,
        terminated: false,
        truncated: true,
        blocked: true,
        episode: u64::MAX,
        step: u32::MAX,
    });
    refused.chain(accepted).collect()
}

/// Returns the peer's encodings of all cases, in hexadecimal digits.
fn encoded_by_peer(cases: &[Case]) -> Vec<String> {
    let python = std::env::var_os("EVAC_PYTHON").expect(
        "EVAC_PYTHON must name a Python interpreter with the packages in \
         tests/peers/requirements.txt: run launch_scripts/test.sh",
    );
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut peer = Command::new(&python)
        .arg(tests.join("peers/cdr_encoder.py"))
        .arg(tests.join("../msgs"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("EVAC_PYTHON={}: {error}", python.display()));
    let requests: Vec<&Value> = cases.iter().map(|case| &case.request).collect();
    let mut input = peer.stdin.take().expect("standard input is piped");
    serde_json::to_writer(&mut input, &requests).expect("the peer reads its input");
    drop(input);
    let output = peer.wait_with_output().expect("the peer exits");
    assert!(output.status.success(), "cdr_encoder.py: {}", output.status);
    serde_json::from_slice(&output.stdout).expect("the peer prints a list of strings")
}

#[test]
fn every_message_matches_an_independent_encoder() {
    let cases: Vec<Case> = [
        message_cases(&times()),
        message_cases(&headers()),
        message_cases(&images()),
        message_cases(&action_commands()),
        message_cases(&episode_statuses()),
        message_cases(&q_values()),
        message_cases(&training_statuses()),
        message_cases(&type_descriptions()),
        // Generated types of standard messages, with arrays of 36 elements, defaults and constants.
        message_cases(&[odometry()]),
        message_cases(&[Marker { id: Marker::CYLINDER, ..Marker::default() }]),
        message_cases(&[CameraInfo { k: [0.5; 9], p: [1.5; 12], ..CameraInfo::default() }]),
        service_cases::<Reset>(&reset_requests(), &reset_responses()),
        service_cases::<Step>(&step_requests(), &step_responses()),
    ]
    .into_iter()
    .flatten()
    .collect();
    let encodings = encoded_by_peer(&cases);
    assert_eq!(cases.len(), encodings.len());
    for (case, encoding) in cases.iter().zip(encodings) {
        let bytes: String = case.bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(bytes, encoding, "{}", case.request);
    }
}
