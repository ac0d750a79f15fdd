//! A malicious participant in the DDS domain: it writes arbitrary bytes to any topic and sends
//! arbitrary packets to the ports of the other participants.

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

use crate::{TIMEOUT, packets::Endpoint};

/// A malicious participant.
pub struct Attacker {
    participant: DomainParticipant,
    publisher: Publisher,
    subscriber: Subscriber,
    socket: UdpSocket,
    domain_id: u16,
    /// Its readers and writers. Packets with their GUIDs are accepted by matched participants.
    own: Vec<Endpoint>,
    others: Vec<Endpoint>,
    readers: Vec<no_key::DataReader<u8>>,
}

/// A writer that publishes byte strings as serialized messages, without the encapsulation header.
pub struct RawWriter(DataWriter<Vec<u8>, RawBytes>);

struct RawBytes;

impl no_key::SerializerAdapter<Vec<u8>> for RawBytes {
    type Error = io::Error;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(value: &Vec<u8>) -> io::Result<Bytes> {
        Ok(Bytes::copy_from_slice(value))
    }
}

impl RawWriter {
    /// Publishes the bytes as one sample. Drops it if the readers cannot keep up.
    pub fn write(&self, bytes: Vec<u8>) {
        let _ = self.0.write(bytes, None);
    }
}

impl Attacker {
    /// Joins the domain, without any endpoints.
    ///
    /// # Panics
    ///
    /// Panics if the participant or its socket cannot be created.
    pub fn new(discovery: Discovery) -> Attacker {
        let participant = discovery.participant(Default::default()).expect("a participant");
        let publisher = participant.create_publisher(&qos()).expect("a publisher");
        let subscriber = participant.create_subscriber(&qos()).expect("a subscriber");
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a socket");
        let domain_id = discovery.domain_id;
        let (own, others, readers) = (Vec::new(), Vec::new(), Vec::new());
        Attacker { participant, publisher, subscriber, socket, domain_id, own, others, readers }
    }

    /// Creates a writer on a DDS topic such as `rt/action`, with a type such as
    /// `evac_msgs::msg::dds_::ActionCommand_`.
    ///
    /// # Panics
    ///
    /// Panics if the writer cannot be created.
    pub fn writer(&mut self, topic: &str, data_type: &str) -> RawWriter {
        let topic = self.topic(topic, data_type);
        let writer = self.publisher.create_datawriter_no_key(&topic, None).expect("a writer");
        self.own.push(writer.guid().to_bytes());
        RawWriter(writer)
    }

    /// Subscribes to a DDS topic, so that its writers match the attacker.
    ///
    /// # Panics
    ///
    /// Panics if the reader cannot be created.
    pub fn subscribe(&mut self, topic: &str, data_type: &str) {
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

    /// Waits until `count` remote endpoints have matched since the start.
    ///
    /// # Panics
    ///
    /// Panics after [`TIMEOUT`].
    pub fn wait_for_matches(&mut self, count: usize) {
        let listener = self.participant.status_listener();
        let end = Instant::now() + TIMEOUT;
        while self.others.len() < count {
            let matched = self.others.len();
            assert!(Instant::now() < end, "only {matched} of {count} endpoints match the attacker");
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

    /// Returns the attacker's endpoints.
    pub fn own(&self) -> &[Endpoint] {
        &self.own
    }

    /// Returns the remote endpoints that match the attacker's.
    pub fn others(&self) -> &[Endpoint] {
        &self.others
    }

    /// Sends a packet to the discovery and data ports of the first `participants` participants in
    /// the domain.
    pub fn send_packet(&self, packet: &[u8], participants: u16) {
        // The unicast ports of participant 0 (RTPS 2.3, section 9.6.1.1).
        let first = 7400 + 250 * self.domain_id + 10;
        for port in first..first + 2 * participants {
            // Ignores the error from a previous packet to an unused port.
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
