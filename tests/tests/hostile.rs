//! Packets and messages of somebody who means harm, thrown at the nodes while a training runs: it ends as
//! if nothing had been. These tests need a corrected build.

use std::{path::Path, time::Duration};

use evac_msgs::{ActionCommand, reset, step};
use evac_tests::{
    Nodes, Outcome, PATIENCE,
    attacker::{Attacker, Liar},
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
/// What a node may hold whatever it is sent, in MB: each holds some 20 to 60 in peace.
const MOST_MEMORY_MB: f64 = 250.0;

/// A training by the real nodes, and somebody who disturbs it.
struct Scene {
    nodes: Nodes,
    attacker: Attacker,
    episodes: u32,
}

impl Scene {
    /// The simulator is the domain's first node, the attacker its second.
    fn new(episodes: u32) -> Scene {
        assert!(
            is_corrected(),
            "RustDDS is uncorrected: run launch_scripts/setup.sh and build again"
        );
        let mut nodes = Nodes::new();
        nodes.start_simulator(&[&format!("max_steps:={MAX_STEPS}")]);
        nodes.wait_for_log("sim_node", "the room is open");
        let attacker = Attacker::new(nodes.discovery(Security::Off));
        Scene { nodes, attacker, episodes }
    }

    fn start_training(&mut self) {
        let (out, episodes) = (self.nodes.path("run"), self.episodes);
        let parameters = [
            format!("out:='{}'", out.display()),
            format!("episodes:={episodes}"),
            format!("seed:={SEED}"),
            "preset:=paper".to_owned(),
            "evaluation_episodes:=0".to_owned(),
        ];
        let parameters: Vec<&str> = parameters.iter().map(String::as_str).collect();
        self.nodes.start_agent("train", &parameters);
    }

    fn assert_sound(&mut self, name: &str) {
        let memory = self.nodes.memory_mb(name);
        // Not a number once it has ended, as the agent may.
        let is_small = memory.is_nan() || memory < MOST_MEMORY_MB;
        assert!(is_small, "{name} holds {memory} MB:\n{}", self.nodes.log(name));
    }

    /// Waits for the training's end, which is that of an undisturbed one.
    fn assert_ends_as_undisturbed(&mut self) {
        self.nodes.succeed("agent_node", TRAINING);
        let log = self.nodes.log("sim_node");
        assert!(self.nodes.ended("sim_node").is_none(), "sim_node has ended:\n{log}");
        let plan =
            Plan { scenario: "empty".to_owned(), episodes: self.episodes, seed: SEED, rooms: 1 };
        let here = self.nodes.path("here");
        let undisturbed = Outcome::in_process(plan, Preset::Paper, MAX_STEPS, &here);
        Outcome::left_in(&self.nodes.path("run")).assert_is(&undisturbed);
    }
}

/// Makes the attacker known to the simulator, as a writer and as a reader; returns what it writes by.
fn befriend(attacker: &mut Attacker) -> [Liar; 3] {
    let liars = [
        attacker.writer("rq/stepRequest", "evac_msgs::srv::dds_::Step_Request_"),
        attacker.writer("rq/resetRequest", "evac_msgs::srv::dds_::Reset_Request_"),
        attacker.writer("rt/action", "evac_msgs::msg::dds_::ActionCommand_"),
    ];
    attacker.read("rr/stepReply", "evac_msgs::srv::dds_::Step_Response_");
    attacker.read("rt/camera/image", "sensor_msgs::msg::dds_::Image_");
    attacker.wait_for_matches(5);
    liars
}

#[test]
fn packets_that_say_nonsense_disturb_nobody() {
    const PACKETS: u32 = 20_000;
    let mut scene = Scene::new(300);
    let _liars = befriend(&mut scene.attacker);
    scene.start_training();
    scene.nodes.wait_for_steps(1);
    let (own, others) = (scene.attacker.own(), scene.attacker.others());
    let mut packets = Packets::new(1, own, others);
    for _ in 0..PACKETS / 50 {
        (0..50).for_each(|_| scene.attacker.throw(&packets.draw(), 4));
        scene.assert_sound("sim_node");
        scene.assert_sound("agent_node");
        std::thread::sleep(Duration::from_millis(5));
    }
    scene.assert_ends_as_undisturbed();
}

/// Whoever reads, in place of a reader.
const ALL_READERS: [u8; 4] = [0; 4];

fn number(number: i64) -> [u8; 8] {
    let high = ((number >> 32) as i32).to_le_bytes();
    let [a, b, c, d] = (number as u32).to_le_bytes();
    [high[0], high[1], high[2], high[3], a, b, c, d]
}

/// A byte of a sample of so many, as so many fragments of a size from the `first` on.
fn fragments(
    writer: &Endpoint,
    sample: i64,
    first: u32,
    (count, size): (u16, u16),
    whole: u32,
) -> Vec<u8> {
    let sizes = [&first.to_le_bytes()[..], &count.to_le_bytes(), &size.to_le_bytes()].concat();
    let start = [&[0, 0, 28, 0], &ALL_READERS, &writer[12..], &number(sample)].concat();
    packet(writer, DATA_FRAG, &[&start[..], &sizes, &whole.to_le_bytes(), &[0]].concat())
}

/// A GAP of all samples from one on before another, and of those that follow by so many bits.
fn gap(writer: &Endpoint, from: i64, before: i64, bits: u32) -> Vec<u8> {
    let set = [&bits.to_le_bytes()[..], &vec![0xff; bits.div_ceil(8) as usize]].concat();
    let numbers = [number(from), number(before)].concat();
    packet(writer, GAP, &[&ALL_READERS, &writer[12..], &numbers, &set].concat())
}

/// Packets of less than 100 bytes that speak of gigabytes, or of what cannot be: RustDDS 0.15.1 as it
/// is takes as much at once, keeps it, or panics.
fn greedy_packets(attacker: &Attacker) -> Vec<Vec<u8>> {
    // The last byte of an endpoint says what it is.
    let of_kind = |endpoints: &[Endpoint], kind| -> Vec<Endpoint> {
        endpoints.iter().copied().filter(|endpoint| endpoint[15] == kind).collect()
    };
    let (writer, reader) = (0x03, 0x04);
    let own = of_kind(attacker.own(), writer);
    let invented = |number: u16, endpoint: [u8; 4]| -> Endpoint {
        let mut other = [0; 16];
        other[..2].copy_from_slice(&number.to_be_bytes());
        other[2..12].fill(0xab);
        other[12..].copy_from_slice(&endpoint);
        other
    };
    let mut packets = Vec::new();
    for sample in 1..=100 {
        let strangers = [[0, 1, 0, 0xc2], [0, 0, 3, 0xc2], [0, 0, 9, writer]];
        let strangers = strangers.map(|endpoint| invented(sample as u16, endpoint));
        for by in strangers.iter().chain(&own[..1]) {
            // Much more than there is, and as much as may be.
            for whole in [u32::MAX, 1 << 31, 1 << 28, 1 << 24] {
                packets.push(fragments(by, sample, 1, (1, 1), whole));
            }
        }
        for by in strangers.iter().chain(&own[1..2]) {
            // All of the sample, as it says.
            packets.push(fragments(by, 1000 + sample, 1, (65_535, 512), 65_535 * 512));
        }
        for by in strangers.iter().chain(&own[2..]) {
            // Fragments of one size, then of another.
            packets.push(fragments(by, 2000, 1, (1, 60_000), 1 << 20));
            packets.push(fragments(by, 2000 + sample, 30_000_000, (1, 1), 1 << 25));
        }
        for by in &own {
            // What is left out ends before it begins.
            packets.push(gap(by, 1 << 40, 1000 * sample, 256));
        }
    }
    for writer in &own {
        // There are 2^40 samples, which the reader is to ask for; all but the first do not exist.
        let range = [number(1), number(1 << 40)].concat();
        let count = i32::MAX.to_le_bytes();
        let heartbeat = [&ALL_READERS, &writer[12..], &range, &count].concat();
        packets.push(packet(writer, HEARTBEAT, &heartbeat));
        packets.push(gap(writer, 2, 1 << 40, 0));
    }
    let asked = of_kind(attacker.others(), writer);
    for (count, fragment) in (1u32..).zip([u32::MAX, 1 << 31, 0]) {
        for (reader, writer) in
            of_kind(attacker.own(), reader).iter().flat_map(|r| asked.iter().map(move |w| (r, w)))
        {
            // The last of so many fragments is asked for once more, or the one before the first.
            let set = [fragment, 1, 1 << 31, count].map(u32::to_le_bytes).concat();
            let body = [&reader[12..], &writer[12..], &number(1), &set].concat();
            packets.push(packet(reader, NACK_FRAG, &body));
        }
    }
    packets
}

#[test]
fn packets_that_speak_of_gigabytes_disturb_nobody() {
    let mut scene = Scene::new(300);
    let _liars = befriend(&mut scene.attacker);
    scene.start_training();
    scene.nodes.wait_for_steps(1);
    for packets in greedy_packets(&scene.attacker).chunks(20) {
        packets.iter().for_each(|packet| scene.attacker.throw(packet, 4));
        scene.assert_sound("sim_node");
        scene.assert_sound("agent_node");
        std::thread::sleep(Duration::from_millis(2));
    }
    scene.assert_ends_as_undisturbed();
}

#[test]
fn participants_that_there_are_not_are_forgotten() {
    const SUBMESSAGE_OF_NOBODY: u8 = 0x80;
    const MOST_GROWTH_MB: f64 = 10.0;
    let mut scene = Scene::new(12);
    let before = scene.nodes.memory_mb("sim_node");
    for participant in 0..100_000u32 {
        let mut sender = [0xcd; 16];
        sender[..4].copy_from_slice(&participant.to_le_bytes());
        scene.attacker.throw(&packet(&sender, SUBMESSAGE_OF_NOBODY, &[]), 1);
        if participant.is_multiple_of(100) {
            // Or the system drops what the node has no time to read.
            std::thread::sleep(Duration::from_millis(2));
        }
    }
    let grown = scene.nodes.memory_mb("sim_node") - before;
    assert!(grown < MOST_GROWTH_MB, "the simulator has grown by {grown} MB");
    scene.start_training();
    scene.assert_ends_as_undisturbed();
}

/// What is sent to them may have them ask for anything: it is not to be had.
#[test]
fn no_node_may_take_all_the_memory() {
    let mut scene = Scene::new(100_000);
    scene.start_training();
    scene.nodes.wait_for_steps(1);
    assert_eq!(scene.nodes.memory_limit("sim_node"), Some(1 << 30));
    let limit = scene.nodes.memory_limit("agent_node");
    let half = ros_runtime::failure::machine_memory().map(|machine| machine / 2);
    // The system counts in pages.
    let difference = limit.zip(half).map(|(limit, half)| limit.abs_diff(half));
    assert!(difference.is_some_and(|bytes| bytes < 1 << 16), "{limit:?}, not {half:?}");
}

/// A message as it goes over the wire.
fn encoded(message: &impl Serialize) -> Vec<u8> {
    let mut bytes = Vec::new();
    to_writer_with_rep_id(&mut bytes, message, RepresentationIdentifier::CDR_LE)
        .expect("it can be encoded");
    bytes
}

/// What a bad hand makes of a message: its beginnings, and every four bytes of it as the length of
/// something. The last bytes stay: in their place, zeros would be read.
fn spoilt(message: &impl Serialize) -> Vec<Vec<u8>> {
    let whole = encoded(message);
    let ends = 0..whole.len().saturating_sub(3);
    let mut all: Vec<Vec<u8>> = ends.map(|end| whole[..end].to_vec()).collect();
    for place in (0..whole.len().saturating_sub(3)).step_by(4) {
        for length in [u32::MAX, 1 << 31, 1 << 20, 3] {
            let mut other = whole.clone();
            other[place..place + 4].copy_from_slice(&length.to_le_bytes());
            all.push(other);
        }
    }
    all
}

/// A request for nothing that there is: whatever becomes of its bytes, the room stays as it is.
fn refused_step() -> step::Request {
    step::Request { episode: u64::MAX, step: u32::MAX, action: u8::MAX }
}

fn refused_reset(length: usize) -> reset::Request {
    reset::Request { request: 1, seed: 1, scenario: "\u{e9}".repeat(length) }
}

#[test]
fn messages_that_are_wrong_are_refused_thousands_of_times_a_second() {
    const MESSAGES: usize = 30_000;
    let mut scene = Scene::new(300);
    let [steps, resets, actions] = befriend(&mut scene.attacker);
    let set = "rq/sim_node/set_parametersRequest";
    let parameters =
        scene.attacker.writer(set, "rcl_interfaces::srv::dds_::SetParameters_Request_");
    scene.start_training();
    scene.nodes.wait_for_steps(1);
    // The agent hears these, where it waits for the answers of the simulator.
    let replies = scene.attacker.writer("rr/stepReply", "evac_msgs::srv::dds_::Step_Response_");
    scene.attacker.wait_for_matches(7);

    let not_utf8 = [&encoded(&(1u64, 1u64, 4u32))[..], &[0xff, 0xfe, 0xfd, 0]].concat();
    let command = ActionCommand { action: u8::MAX, ..Default::default() };
    let none = (Vec::<u8>::new(), Vec::<bool>::new(), Vec::<i64>::new());
    let value = (8u8, false, 0i64, f64::NAN, "", none, vec![f64::NAN; 3], Vec::<String>::new());
    let change = (vec![("fixed_robot", value)],);
    let lies: [(&Liar, Vec<Vec<u8>>); 5] = [
        (&steps, spoilt(&refused_step())),
        (&resets, {
            let long = [100, 30_000, 500_000].map(|length| encoded(&refused_reset(length)));
            [spoilt(&refused_reset(3)), vec![not_utf8], long.to_vec()].concat()
        }),
        (&actions, spoilt(&command)),
        (&parameters, spoilt(&change)),
        (&replies, spoilt(&step::Response { message: "no".into(), ..Default::default() })),
    ];
    let mut sent = 0;
    while sent < MESSAGES {
        for _ in 0..20 {
            for (liar, messages) in &lies {
                liar.write(messages[sent % messages.len()].clone());
            }
            // Well-formed ones, which the room answers.
            steps.write(encoded(&refused_step()));
            sent += 1;
        }
        scene.assert_sound("sim_node");
        scene.assert_sound("agent_node");
        std::thread::sleep(Duration::from_millis(1));
    }
    scene.assert_ends_as_undisturbed();
}

#[test]
fn images_that_are_none_do_not_stop_a_robot() {
    let mut scene = Scene::new(2);
    scene.start_training();
    scene.assert_ends_as_undisturbed();
    let model = scene.nodes.path("run");
    drive_among_wrong_images(&mut scene, &model);
}

fn drive_among_wrong_images(scene: &mut Scene, model: &Path) {
    let robot = ["frame_rate:=50", "motion_time:=0.02", "auto_reset:=true", "max_steps:=100"];
    scene.nodes.start_simulator(&robot);
    let settle_time = "settle_time:=0.06";
    scene.nodes.start_agent("drive", &[&format!("model:='{}'", model.display()), settle_time]);
    scene.nodes.wait_for_log("agent_node", "there are images");
    let liar = scene.attacker.writer("rt/camera/image", "sensor_msgs::msg::dds_::Image_");
    scene.attacker.wait_for_matches(1);

    let image = Image {
        height: 7,
        width: 20,
        encoding: "rgb8".to_owned(),
        step: 60,
        data: vec![0; 420],
        ..Default::default()
    };
    let wrong = [
        Image { width: u32::MAX, ..image.clone() },
        Image { data: vec![0; 419], ..image.clone() },
        Image { data: vec![0; 1_000_000], ..image.clone() },
        Image { encoding: "32FC3".to_owned(), ..image.clone() },
        Image { encoding: "\u{e9}".repeat(30_000), ..image.clone() },
    ];
    let lies = [spoilt(&wrong[1]), wrong.iter().map(encoded).collect()].concat();
    let node = scene.nodes.client();
    let commands = node.create_subscription::<ActionCommand>("action", reliable(10));
    let commands = commands.expect("a subscription");
    let mut heard = 0;
    for number in 0.. {
        for lie in 0..20 {
            liar.write(lies[(20 * number + lie) % lies.len()].clone());
        }
        while let Ok(Some(_)) = commands.take() {
            heard += 1;
        }
        scene.assert_sound("agent_node");
        assert!(scene.nodes.ended("agent_node").is_none(), "{}", scene.nodes.log("agent_node"));
        // All that may be wrong was sent, and the robot is still told where to go.
        if heard >= 50 && 20 * number > 2 * lies.len() {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    scene.nodes.signal("agent_node", "INT");
    scene.nodes.succeed("agent_node", PATIENCE);
}
