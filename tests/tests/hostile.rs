//! Attacks the nodes with malicious packets and messages during a training run. The training must
//! finish with the same result as an undisturbed run. These tests need a corrected build.

use std::{path::Path, time::Duration};

use evac_msgs::{ActionCommand, reset, step};
use evac_tests::{
    Nodes, Outcome, TIMEOUT,
    attacker::{Attacker, RawWriter},
    packets::{DATA_FRAG, Endpoint, GAP, HEARTBEAT, NACK_FRAG, Packets, packet},
};
use learning::{settings::Preset, training::Plan};
use ros_interfaces::sensor_msgs::Image;
use ros_runtime::{corrections::is_corrected, node::reliable, security::Security};
use rustdds::{RepresentationIdentifier, serialization::to_writer_with_rep_id};
use serde::Serialize;

const TRAINING: Duration = Duration::from_secs(600);
const MAX_STEPS: u32 = 60;
const SEED: u64 = 5;
/// Upper limit of a node's resident memory under attack, in MB. Normally, a node uses 20 to 60 MB.
const MAX_MEMORY_MB: f64 = 250.0;

/// The nodes and an attacker in the same domain.
struct Fixture {
    nodes: Nodes,
    attacker: Attacker,
    /// Number of training episodes.
    episodes: u32,
}

impl Fixture {
    /// Starts the simulator, as the first participant of the domain, and then the attacker.
    fn new(episodes: u32) -> Fixture {
        assert!(is_corrected(), "RustDDS is not patched: run launch_scripts/setup.sh and rebuild");
        let mut nodes = Nodes::new();
        nodes.start_simulator(&[&format!("max_steps:={MAX_STEPS}")]);
        nodes.wait_for_log("sim_node", "simulator ready");
        let attacker = Attacker::new(nodes.discovery(Security::Off));
        Fixture { nodes, attacker, episodes }
    }

    fn start_training(&mut self) {
        let (out, episodes) = (self.nodes.path("run"), self.episodes);
        let parameters = [
            format!("out:='{}'", out.display()),
            format!("episodes:={episodes}"),
            format!("seed:={SEED}"),
            "preset:=paper".to_owned(),
            "scenario:=empty".to_owned(),
            "evaluation_episodes:=0".to_owned(),
        ];
        let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
        self.nodes.start_agent("train", &parameters);
    }

    fn assert_memory_is_bounded(&mut self, name: &str) {
        let memory = self.nodes.memory_mb(name);
        // NaN: the process has exited, as the agent does at the end of the training.
        let is_bounded = memory.is_nan() || memory < MAX_MEMORY_MB;
        assert!(is_bounded, "{name} uses {memory} MB:\n{}", self.nodes.log(name));
    }

    /// Waits for the end of the training and asserts that its result is undisturbed.
    fn assert_result_is_undisturbed(&mut self) {
        self.nodes.succeed("agent_node", TRAINING);
        let log = self.nodes.log("sim_node");
        assert!(self.nodes.ended("sim_node").is_none(), "sim_node exited:\n{log}");
        let plan =
            Plan { scenario: "empty".to_owned(), episodes: self.episodes, seed: SEED, rooms: 1 };
        let here = self.nodes.path("here");
        let undisturbed = Outcome::in_process(plan, Preset::Paper, MAX_STEPS, &here);
        Outcome::read_from(&self.nodes.path("run")).assert_identical(&undisturbed);
    }
}

/// Creates readers and writers that match the simulator's endpoints, so that it accepts the
/// attacker's packets. Returns the writers for steps, resets and actions.
fn match_simulator(attacker: &mut Attacker) -> [RawWriter; 3] {
    let writers = [
        attacker.writer("rq/stepRequest", "evac_msgs::srv::dds_::Step_Request_"),
        attacker.writer("rq/resetRequest", "evac_msgs::srv::dds_::Reset_Request_"),
        attacker.writer("rt/action", "evac_msgs::msg::dds_::ActionCommand_"),
    ];
    attacker.subscribe("rr/stepReply", "evac_msgs::srv::dds_::Step_Response_");
    attacker.subscribe("rt/camera/image", "sensor_msgs::msg::dds_::Image_");
    attacker.wait_for_matches(5);
    writers
}

#[test]
fn training_survives_random_packets() {
    const PACKETS: u32 = 20_000;
    let mut fixture = Fixture::new(300);
    let _writers = match_simulator(&mut fixture.attacker);
    fixture.start_training();
    fixture.nodes.wait_for_steps(1);
    let (own, others) = (fixture.attacker.own(), fixture.attacker.others());
    let mut packets = Packets::new(1, own, others);
    for _ in 0..PACKETS / 50 {
        (0..50).for_each(|_| fixture.attacker.send_packet(&packets.draw(), 4));
        fixture.assert_memory_is_bounded("sim_node");
        fixture.assert_memory_is_bounded("agent_node");
        std::thread::sleep(Duration::from_millis(5));
    }
    fixture.assert_result_is_undisturbed();
}

/// The entity ID that addresses all readers of a writer.
const ALL_READERS: [u8; 4] = [0; 4];

/// Encodes a sequence number.
fn sequence_number(number: i64) -> [u8; 8] {
    let high = ((number >> 32) as i32).to_le_bytes();
    let [a, b, c, d] = (number as u32).to_le_bytes();
    [high[0], high[1], high[2], high[3], a, b, c, d]
}

/// Returns a DATA_FRAG packet for a sample of `sample_size` bytes that announces `count` fragments
/// of `size` bytes, starting with number `first`, but contains only one byte of them.
fn fragments(
    writer: &Endpoint,
    sample: i64,
    first: u32,
    (count, size): (u16, u16),
    sample_size: u32,
) -> Vec<u8> {
    let sizes = [&first.to_le_bytes()[..], &count.to_le_bytes(), &size.to_le_bytes()].concat();
    let start = [&[0, 0, 28, 0], &ALL_READERS, &writer[12..], &sequence_number(sample)].concat();
    packet(writer, DATA_FRAG, &[&start[..], &sizes, &sample_size.to_le_bytes(), &[0]].concat())
}

/// Returns a GAP packet for the samples from `first` to `base - 1` and for `bits` samples from
/// `base` on.
fn gap(writer: &Endpoint, first: i64, base: i64, bits: u32) -> Vec<u8> {
    let set = [&bits.to_le_bytes()[..], &vec![0xff; bits.div_ceil(8) as usize]].concat();
    let numbers = [sequence_number(first), sequence_number(base)].concat();
    packet(writer, GAP, &[&ALL_READERS, &writer[12..], &numbers, &set].concat())
}

/// Returns packets smaller than 100 bytes that announce gigabytes or contradict themselves. Without
/// corrections, RustDDS 0.15.1 allocates that memory, fails to release it, or panics.
fn exhausting_packets(attacker: &Attacker) -> Vec<Vec<u8>> {
    // The last byte of a GUID is the kind of the endpoint.
    let of_kind = |endpoints: &[Endpoint], kind| -> Vec<Endpoint> {
        endpoints.iter().copied().filter(|endpoint| endpoint[15] == kind).collect()
    };
    let (writer, reader) = (0x03, 0x04);
    let own = of_kind(attacker.own(), writer);
    let unknown_endpoint = |number: u16, entity_id: [u8; 4]| -> Endpoint {
        let mut endpoint = [0; 16];
        endpoint[..2].copy_from_slice(&number.to_be_bytes());
        endpoint[2..12].fill(0xab);
        endpoint[12..].copy_from_slice(&entity_id);
        endpoint
    };
    let mut packets = Vec::new();
    for sample in 1..=100 {
        let unknown = [[0, 1, 0, 0xc2], [0, 0, 3, 0xc2], [0, 0, 9, writer]];
        let unknown = unknown.map(|entity_id| unknown_endpoint(sample as u16, entity_id));
        for by in unknown.iter().chain(&own[..1]) {
            // Sample sizes far beyond the fragments sent, up to the maximum.
            for sample_size in [u32::MAX, 1 << 31, 1 << 28, 1 << 24] {
                packets.push(fragments(by, sample, 1, (1, 1), sample_size));
            }
        }
        for by in unknown.iter().chain(&own[1..2]) {
            // Claims to contain the whole sample.
            packets.push(fragments(by, 1000 + sample, 1, (65_535, 512), 65_535 * 512));
        }
        for by in unknown.iter().chain(&own[2..]) {
            // Fragments of different sizes.
            packets.push(fragments(by, 2000, 1, (1, 60_000), 1 << 20));
            packets.push(fragments(by, 2000 + sample, 30_000_000, (1, 1), 1 << 25));
        }
        for by in &own {
            // A gap that ends before it begins.
            packets.push(gap(by, 1 << 40, 1000 * sample, 256));
        }
    }
    for writer in &own {
        // Announces 2^40 samples, which the reader will request, then declares all but the first
        // and the last irrelevant.
        let range = [sequence_number(1), sequence_number(1 << 40)].concat();
        let count = i32::MAX.to_le_bytes();
        let heartbeat = [&ALL_READERS, &writer[12..], &range, &count].concat();
        packets.push(packet(writer, HEARTBEAT, &heartbeat));
        packets.push(gap(writer, 2, 1 << 40, 0));
    }
    let (own_readers, remote_writers) =
        (of_kind(attacker.own(), reader), of_kind(attacker.others(), writer));
    // Requests a fragment that does not exist: a huge number, or 0, although numbers start at 1.
    for (count, fragment) in (1u32..).zip([u32::MAX, 1 << 31, 0]) {
        let set = [fragment, 1, 1 << 31, count].map(u32::to_le_bytes).concat();
        for reader in &own_readers {
            for writer in &remote_writers {
                let body = [&reader[12..], &writer[12..], &sequence_number(1), &set].concat();
                packets.push(packet(reader, NACK_FRAG, &body));
            }
        }
    }
    packets
}

#[test]
fn training_survives_packets_that_announce_gigabytes() {
    let mut fixture = Fixture::new(300);
    let _writers = match_simulator(&mut fixture.attacker);
    fixture.start_training();
    fixture.nodes.wait_for_steps(1);
    for packets in exhausting_packets(&fixture.attacker).chunks(20) {
        packets.iter().for_each(|packet| fixture.attacker.send_packet(packet, 4));
        fixture.assert_memory_is_bounded("sim_node");
        fixture.assert_memory_is_bounded("agent_node");
        std::thread::sleep(Duration::from_millis(2));
    }
    fixture.assert_result_is_undisturbed();
}

#[test]
fn memory_stays_bounded_with_100_000_unknown_participants() {
    const VENDOR_SPECIFIC_SUBMESSAGE: u8 = 0x80;
    const MAX_GROWTH_MB: f64 = 10.0;
    let mut fixture = Fixture::new(12);
    let before = fixture.nodes.memory_mb("sim_node");
    for participant in 0..100_000u32 {
        let mut sender = [0xcd; 16];
        sender[..4].copy_from_slice(&participant.to_le_bytes());
        fixture.attacker.send_packet(&packet(&sender, VENDOR_SPECIFIC_SUBMESSAGE, &[]), 1);
        if participant.is_multiple_of(100) {
            // Without pauses, the simulator's socket buffer overflows and packets are dropped.
            std::thread::sleep(Duration::from_millis(2));
        }
    }
    let growth = fixture.nodes.memory_mb("sim_node") - before;
    assert!(growth < MAX_GROWTH_MB, "the memory of sim_node grew by {growth} MB");
    fixture.start_training();
    fixture.assert_result_is_undisturbed();
}

/// The limits keep a node from exhausting the machine's memory, whatever it is made to allocate.
#[test]
fn both_nodes_limit_their_memory() {
    let mut fixture = Fixture::new(100_000);
    fixture.start_training();
    fixture.nodes.wait_for_steps(1);
    assert_eq!(fixture.nodes.memory_limit("sim_node"), Some(1 << 30));
    let limit = fixture.nodes.memory_limit("agent_node");
    let half = ros_runtime::failure::machine_memory().map(|machine| machine / 2);
    // The kernel rounds the limit to pages.
    let difference = limit.zip(half).map(|(limit, half)| limit.abs_diff(half));
    assert!(difference.is_some_and(|bytes| bytes < 1 << 16), "{limit:?} (expected: {half:?})");
}

/// Serializes a message as little-endian CDR.
fn encoded(message: &impl Serialize) -> Vec<u8> {
    let mut bytes = Vec::new();
    to_writer_with_rep_id(&mut bytes, message, RepresentationIdentifier::CDR_LE)
        .expect("the message can be encoded");
    bytes
}

/// Returns malformed encodings of a message: its truncations, and copies in which one of its 32-bit
/// words is replaced by a wrong length. Truncations lack at least four bytes, because up to three
/// missing bytes are decoded as zeros.
fn malformed(message: &impl Serialize) -> Vec<Vec<u8>> {
    let valid = encoded(message);
    let ends = 0..valid.len().saturating_sub(3);
    let mut all: Vec<Vec<u8>> = ends.map(|end| valid[..end].to_vec()).collect();
    for index in (0..valid.len().saturating_sub(3)).step_by(4) {
        for length in [u32::MAX, 1 << 31, 1 << 20, 3] {
            let mut other = valid.clone();
            other[index..index + 4].copy_from_slice(&length.to_le_bytes());
            all.push(other);
        }
    }
    all
}

/// Returns a request that is refused, even after one of its words has been replaced.
fn refused_step() -> step::Request {
    step::Request { episode: u64::MAX, step: u32::MAX, action: u8::MAX }
}

/// Returns a request with an unknown scenario of `length` characters.
fn refused_reset(length: usize) -> reset::Request {
    reset::Request { request: 1, seed: 1, scenario: "\u{e9}".repeat(length) }
}

#[test]
fn training_survives_malformed_messages() {
    const MESSAGES: usize = 30_000;
    let mut fixture = Fixture::new(300);
    let [steps, resets, actions] = match_simulator(&mut fixture.attacker);
    let set = "rq/sim_node/set_parametersRequest";
    let parameters =
        fixture.attacker.writer(set, "rcl_interfaces::srv::dds_::SetParameters_Request_");
    fixture.start_training();
    fixture.nodes.wait_for_steps(1);
    // The agent receives these replies on the topic of the simulator's responses.
    let replies = fixture.attacker.writer("rr/stepReply", "evac_msgs::srv::dds_::Step_Response_");
    fixture.attacker.wait_for_matches(7);

    let not_utf8 = [&encoded(&(1u64, 1u64, 4u32))[..], &[0xff, 0xfe, 0xfd, 0]].concat();
    let command = ActionCommand { action: u8::MAX, ..Default::default() };
    let none = (Vec::<u8>::new(), Vec::<bool>::new(), Vec::<i64>::new());
    let value = (8u8, false, 0i64, f64::NAN, "", none, vec![f64::NAN; 3], Vec::<String>::new());
    let change = (vec![("fixed_robot", value)],);
    let attacks: [(&RawWriter, Vec<Vec<u8>>); 5] = [
        (&steps, malformed(&refused_step())),
        (&resets, {
            let long = [100, 30_000, 500_000].map(|length| encoded(&refused_reset(length)));
            [malformed(&refused_reset(3)), vec![not_utf8], long.to_vec()].concat()
        }),
        (&actions, malformed(&command)),
        (&parameters, malformed(&change)),
        (&replies, malformed(&step::Response { message: "no".into(), ..Default::default() })),
    ];
    let mut sent = 0;
    while sent < MESSAGES {
        for _ in 0..20 {
            for (writer, messages) in &attacks {
                writer.write(messages[sent % messages.len()].clone());
            }
            // Well-formed requests, which the simulator answers with a refusal.
            steps.write(encoded(&refused_step()));
            sent += 1;
        }
        fixture.assert_memory_is_bounded("sim_node");
        fixture.assert_memory_is_bounded("agent_node");
        std::thread::sleep(Duration::from_millis(1));
    }
    fixture.assert_result_is_undisturbed();
}

#[test]
fn a_deployed_agent_survives_malformed_images() {
    let mut fixture = Fixture::new(2);
    fixture.start_training();
    fixture.assert_result_is_undisturbed();
    let model = fixture.nodes.path("run");
    drive_with_malformed_images(&mut fixture, &model);
}

fn drive_with_malformed_images(fixture: &mut Fixture, model: &Path) {
    let robot = ["frame_rate:=50", "motion_time:=0.02", "auto_reset:=true", "max_steps:=100"];
    fixture.nodes.start_simulator(&robot);
    let settle_time = "settle_time:=0.06";
    fixture.nodes.start_agent("drive", &[&format!("model:='{}'", model.display()), settle_time]);
    fixture.nodes.wait_for_log("agent_node", "receiving images");
    let writer = fixture.attacker.writer("rt/camera/image", "sensor_msgs::msg::dds_::Image_");
    fixture.attacker.wait_for_matches(1);

    let image = Image {
        height: 7,
        width: 20,
        encoding: "rgb8".to_owned(),
        step: 60,
        data: vec![0; 420],
        ..Default::default()
    };
    let invalid = [
        Image { width: u32::MAX, ..image.clone() },
        Image { data: vec![0; 419], ..image.clone() },
        Image { data: vec![0; 1_000_000], ..image.clone() },
        Image { encoding: "32FC3".to_owned(), ..image.clone() },
        Image { encoding: "\u{e9}".repeat(30_000), ..image.clone() },
    ];
    let attacks = [malformed(&invalid[1]), invalid.iter().map(encoded).collect()].concat();
    let node = fixture.nodes.client();
    let commands = node.create_subscription::<ActionCommand>("action", reliable(10));
    let commands = commands.expect("a subscription");
    let mut received = 0;
    for round in 0.. {
        for attack in 0..20 {
            writer.write(attacks[(20 * round + attack) % attacks.len()].clone());
        }
        while let Ok(Some(_)) = commands.take() {
            received += 1;
        }
        fixture.assert_memory_is_bounded("agent_node");
        assert!(fixture.nodes.ended("agent_node").is_none(), "{}", fixture.nodes.log("agent_node"));
        // Every malformed image has been sent, and the agent still sends commands.
        if received >= 50 && 20 * round > 2 * attacks.len() {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    fixture.nodes.signal("agent_node", "INT");
    fixture.nodes.succeed("agent_node", TIMEOUT);
}
