//! A member of the DDS domain that nobody wants: it says whatever it likes on any topic, and throws
//! packets at the others' ports.

use std::{
    io,
    net::{Ipv4Addr, UdpSocket},
    thread,
    time::{Duration, Instant},
};

use ros_runtime::discovery::Discovery;
use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent as Event, Publisher, QosPolicies, RTPSEntity,
    RepresentationIdentifier, StatusEvented, Subscriber, TopicKind,
    bytes::Bytes,
    no_key::{self, DataWriter},
    policy::{History, Reliability},
};

use crate::{PATIENCE, packets::Endpoint};

/// The member.
pub struct Attacker {
    participant: DomainParticipant,
    publisher: Publisher,
    subscriber: Subscriber,
    socket: UdpSocket,
    domain_id: u16,
    /// The readers and writers of the attacker's, so that others take its packets for theirs.
    own: Vec<Endpoint>,
    others: Vec<Endpoint>,
    readers: Vec<no_key::DataReader<u8>>,
}

/// A writer of a topic, which takes the bytes of a message as they are, after its encoding.
pub struct Liar(DataWriter<Vec<u8>, AsItIs>);

struct AsItIs;

impl no_key::SerializerAdapter<Vec<u8>> for AsItIs {
    type Error = io::Error;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(value: &Vec<u8>) -> io::Result<Bytes> {
        Ok(Bytes::copy_from_slice(value))
    }
}

impl Liar {
    /// Writes these bytes; none of them if the readers cannot keep up.
    pub fn write(&self, bytes: Vec<u8>) {
        let _ = self.0.write(bytes, None);
    }
}

impl Attacker {
    /// Joins the domain, and makes itself known to whoever serves `/step` in it.
    pub fn new(discovery: Discovery) -> Attacker {
        let participant = discovery.participant(Default::default()).expect("a participant");
        let publisher = participant.create_publisher(&qos()).expect("a publisher");
        let subscriber = participant.create_subscriber(&qos()).expect("a subscriber");
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a socket");
        let domain_id = discovery.domain_id;
        let (own, others, readers) = (Vec::new(), Vec::new(), Vec::new());
        Attacker { participant, publisher, subscriber, socket, domain_id, own, others, readers }
    }

    /// A writer on a DDS topic, such as `rt/action` with `evac_msgs::msg::dds_::ActionCommand_`.
    pub fn writer(&mut self, topic: &str, data_type: &str) -> Liar {
        let topic = self.topic(topic, data_type);
        let writer = self.publisher.create_datawriter_no_key(&topic, None).expect("a writer");
        self.own.push(writer.guid().to_bytes());
        Liar(writer)
    }

    /// Reads a topic, so that its writers are matched.
    pub fn read(&mut self, topic: &str, data_type: &str) {
        let topic = self.topic(topic, data_type);
        let reader = self.subscriber.create_datareader_no_key_cdr(&topic, None).expect("a reader");
        self.own.push(reader.guid().to_bytes());
        self.readers.push(reader);
    }

    fn topic(&self, topic: &str, data_type: &str) -> rustdds::Topic {
        let (topic, data_type) = (topic.to_owned(), data_type.to_owned());
        let kind = TopicKind::NoKey;
        self.participant.create_topic(topic, data_type, &qos(), kind).expect("a topic")
    }

    /// Waits until the attacker's endpoints match with so many of the others.
    pub fn wait_for_matches(&mut self, count: usize) {
        let listener = self.participant.status_listener();
        let end = Instant::now() + PATIENCE;
        while self.others.len() < count {
            assert!(Instant::now() < end, "nobody hears the attacker");
            let Some(event) = listener.try_recv_status() else {
                thread::sleep(Duration::from_millis(5));
                continue;
            };
            if let Event::RemoteReaderMatched { remote_reader: other, .. }
            | Event::RemoteWriterMatched { remote_writer: other, .. } = event
            {
                self.others.push(other.to_bytes());
            }
        }
    }

    /// The endpoints of the attacker's.
    pub fn own(&self) -> &[Endpoint] {
        &self.own
    }

    /// The endpoints of others that are matched with the attacker's.
    pub fn others(&self) -> &[Endpoint] {
        &self.others
    }

    /// Throws a packet at the ports where the first nodes of the domain hear discovery, and data.
    pub fn throw(&self, packet: &[u8], nodes: u16) {
        // As RTPS numbers them.
        let first = 7400 + 250 * self.domain_id + 10;
        for port in first..first + 2 * nodes {
            // Where nobody listens, the system says so at the next packet.
            let _ = self.socket.send_to(packet, (Ipv4Addr::LOCALHOST, port));
        }
    }
}

fn qos() -> QosPolicies {
    QosPolicies::builder()
        .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::ZERO })
        .history(History::KeepLast { depth: 10 })
        .build()
}
