//! A generator of malformed RTPS packets. Headers and submessages have a valid structure, so that
//! packets reach the inner parsing stages; lengths, counts, sequence numbers and contents are
//! random.

use rand::{Rng, RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

const ACKNACK: u8 = 0x06;
/// Submessage ID of HEARTBEAT: a writer announces which samples it has.
pub const HEARTBEAT: u8 = 0x07;
/// Submessage ID of GAP: a writer announces which samples are irrelevant.
pub const GAP: u8 = 0x08;
const INFO_TS: u8 = 0x09;
const INFO_SRC: u8 = 0x0c;
const INFO_DST: u8 = 0x0e;
const INFO_REPLY: u8 = 0x0f;
/// Submessage ID of NACK_FRAG: a reader requests fragments of a sample.
pub const NACK_FRAG: u8 = 0x12;
const HEARTBEAT_FRAG: u8 = 0x13;
const DATA: u8 = 0x15;
/// Submessage ID of DATA_FRAG: a fragment of a sample.
pub const DATA_FRAG: u8 = 0x16;

/// Entity IDs of the built-in endpoints: discovery of participants, topics, publications and
/// subscriptions, and participant messages (liveliness).
const BUILT_IN: [[u8; 4]; 10] = [
    [0x00, 0x01, 0x00, 0xc2],
    [0x00, 0x01, 0x00, 0xc7],
    [0x00, 0x00, 0x02, 0xc2],
    [0x00, 0x00, 0x02, 0xc7],
    [0x00, 0x00, 0x03, 0xc2],
    [0x00, 0x00, 0x03, 0xc7],
    [0x00, 0x00, 0x04, 0xc2],
    [0x00, 0x00, 0x04, 0xc7],
    [0x00, 0x02, 0x00, 0xc2],
    [0x00, 0x02, 0x00, 0xc7],
];
/// Submessage flag for little-endian encoding.
const LITTLE_ENDIAN: u8 = 1;
/// The entity ID that addresses all readers of a writer.
const ALL_READERS: [u8; 4] = [0; 4];

/// IDs of discovery parameters that do not contain locators.
const PARAMETERS: [u16; 24] = [
    0x0002, 0x0004, 0x0005, 0x0007, 0x0015, 0x0016, 0x001a, 0x001b, 0x001d, 0x001f, 0x0021, 0x0023,
    0x0025, 0x002c, 0x0034, 0x0040, 0x0041, 0x0050, 0x0058, 0x005a, 0x0062, 0x0070, 0x0071, 0x0073,
];
/// IDs of discovery parameters that contain a locator. The generated locators always have loopback
/// addresses, so that no reply leaves this machine.
const LOCATORS: [u16; 4] = [0x002f, 0x0031, 0x0032, 0x0048];

/// The GUID of an endpoint: the participant's prefix (12 bytes) and the entity ID (4 bytes).
pub type Endpoint = [u8; 16];

/// Returns a packet with one submessage from the participant of `sender`.
pub fn packet(sender: &Endpoint, kind: u8, body: &[u8]) -> Vec<u8> {
    let mut packet = header(sender);
    append_header(&mut packet, kind, LITTLE_ENDIAN, body.len() as u16);
    packet.extend(body);
    packet
}

fn header(sender: &Endpoint) -> Vec<u8> {
    // Protocol version 2.4 and the vendor ID of RustDDS.
    [&b"RTPS"[..], &[2, 4, 1, 18], &sender[..12]].concat()
}

fn append_header(packet: &mut Vec<u8>, kind: u8, flags: u8, length: u16) {
    packet.extend([kind, flags]);
    packet.extend(length.to_le_bytes());
}

/// A generator of random packets. The same seed gives the same packets.
pub struct Packets {
    random: ChaCha8Rng,
    senders: Vec<Endpoint>,
    receivers: Vec<Endpoint>,
}

impl Packets {
    /// Creates a generator of packets from the endpoints `senders` to the endpoints `receivers`.
    pub fn new(seed: u64, senders: &[Endpoint], receivers: &[Endpoint]) -> Packets {
        Packets {
            random: ChaCha8Rng::seed_from_u64(seed),
            senders: senders.to_vec(),
            receivers: receivers.to_vec(),
        }
    }

    /// Returns the next packet: one to four submessages, sometimes truncated or with flipped bits.
    pub fn draw(&mut self) -> Vec<u8> {
        let mut sender = self.pick(&self.senders.clone());
        if self.random.random_bool(0.2) {
            // An unknown participant.
            self.random.fill_bytes(&mut sender[..12]);
        }
        let mut packet = header(&sender);
        let mut has_locator = false;
        for _ in 0..self.random.random_range(1..=4) {
            has_locator |= self.append_submessage(&mut packet, &sender);
        }
        match self.random.random_range(0..8) {
            0 => packet.truncate(self.random.random_range(0..=packet.len())),
            // A flipped bit in a locator could address another machine.
            1..=3 if !has_locator => {
                for _ in 0..self.random.random_range(1..=3) {
                    let index = self.random.random_range(0..packet.len());
                    packet[index] ^= 1 << self.random.random_range(0..8);
                }
            }
            _ => {}
        }
        packet
    }

    /// Appends a submessage. Returns whether it contains a locator.
    fn append_submessage(&mut self, packet: &mut Vec<u8>, sender: &Endpoint) -> bool {
        let kind = self.pick(&[
            ACKNACK,
            HEARTBEAT,
            GAP,
            INFO_TS,
            INFO_SRC,
            INFO_DST,
            INFO_REPLY,
            NACK_FRAG,
            HEARTBEAT_FRAG,
            DATA,
            DATA,
            DATA,
            DATA_FRAG,
            DATA_FRAG,
        ]);
        // The meaning of the other flags depends on the submessage.
        let any = self.random.random();
        let mut flags = LITTLE_ENDIAN | self.pick(&[0, 0, 2, 4, 6, 8, any]);
        let mut body = Vec::new();
        let mut has_locator = false;
        match kind {
            ACKNACK => {
                self.append_endpoints(&mut body, sender, false);
                self.append_number(&mut body);
                self.append_bitmap(&mut body);
                self.append_count(&mut body);
            }
            HEARTBEAT => {
                self.append_endpoints(&mut body, sender, true);
                self.append_number(&mut body);
                self.append_number(&mut body);
                self.append_count(&mut body);
            }
            GAP => {
                self.append_endpoints(&mut body, sender, true);
                self.append_number(&mut body);
                self.append_number(&mut body);
                self.append_bitmap(&mut body);
            }
            NACK_FRAG => {
                self.append_endpoints(&mut body, sender, false);
                self.append_number(&mut body);
                self.append_size(&mut body);
                self.append_bitmap(&mut body);
                self.append_count(&mut body);
            }
            HEARTBEAT_FRAG => {
                self.append_endpoints(&mut body, sender, true);
                self.append_number(&mut body);
                self.append_size(&mut body);
                self.append_count(&mut body);
            }
            DATA => {
                body.extend([0, 0, 16, 0]);
                self.append_endpoints(&mut body, sender, true);
                self.append_number(&mut body);
                if flags & 2 != 0 {
                    has_locator |= self.append_parameters(&mut body);
                }
                has_locator |= self.append_payload(&mut body);
            }
            DATA_FRAG => {
                body.extend([0, 0, 28, 0]);
                self.append_endpoints(&mut body, sender, true);
                self.append_number(&mut body);
                self.append_size(&mut body);
                body.extend(self.small().to_le_bytes());
                body.extend(self.small().to_le_bytes());
                self.append_size(&mut body);
                if flags & 2 != 0 {
                    has_locator |= self.append_parameters(&mut body);
                }
                self.append_noise(&mut body, 300);
            }
            INFO_DST => {
                let receiver = self.pick(&self.receivers.clone());
                body.extend(&receiver[..12]);
            }
            INFO_SRC => {
                let source = self.pick(&self.senders.clone());
                body.extend([0, 0, 0, 0, 2, 4, 1, 18]);
                body.extend(&source[..12]);
            }
            INFO_REPLY => {
                flags &= !2;
                body.extend(1u32.to_le_bytes());
                self.append_locator(&mut body);
                has_locator = true;
            }
            _ => self.append_noise(&mut body, 12),
        }
        let length = match self.random.random_range(0..20) {
            0 => self.random.random(),
            1 => 0,
            _ => body.len() as u16,
        };
        append_header(packet, kind, flags, length);
        packet.extend(body);
        has_locator
    }

    fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        *all.choose(&mut self.random).expect("a non-empty slice")
    }

    /// Appends the entity IDs of the reader and the writer of a submessage. `sender` is the writer
    /// if `by_writer` is true, otherwise the reader.
    fn append_endpoints(&mut self, body: &mut Vec<u8>, sender: &Endpoint, by_writer: bool) {
        let receiver = self.pick(&self.receivers.clone());
        for owner in if by_writer { [receiver, *sender] } else { [*sender, receiver] } {
            let entity_id = match self.random.random_range(0..4) {
                0 => self.pick(&BUILT_IN),
                1 => ALL_READERS,
                _ => [owner[12], owner[13], owner[14], owner[15]],
            };
            body.extend(entity_id);
        }
    }

    /// Appends a sequence number: three out of four are between 0 and 100; the others are extreme.
    fn append_number(&mut self, body: &mut Vec<u8>) {
        let max = i64::MAX;
        let number = match self.random.random_range(0..4) {
            0 => self.pick(&[0, -1, i64::MIN, i64::MIN + 1, max, max - 1]),
            _ => self.random.random_range(0..=100),
        };
        body.extend(((number >> 32) as i32).to_le_bytes());
        body.extend((number as u32).to_le_bytes());
    }

    /// Appends a size or fragment number: three out of four are between 1 and 2000; the others are
    /// extreme.
    fn append_size(&mut self, body: &mut Vec<u8>) {
        let max = u32::MAX;
        let size = match self.random.random_range(0..4) {
            0 => self.pick(&[max, max - 1, max / 2, 1, 0]),
            _ => self.random.random_range(1..=2000),
        };
        body.extend(size.to_le_bytes());
    }

    fn small(&mut self) -> u16 {
        let any = self.random.random();
        self.pick(&[0, 1, 2, 3, 100, 1000, u16::MAX, any])
    }

    fn append_bitmap(&mut self, body: &mut Vec<u8>) {
        let bits: u32 = self.pick(&[0, 1, 31, 32, 33, 255, 256, 257, u32::MAX]);
        body.extend(bits.to_le_bytes());
        for _ in 0..bits.min(256).div_ceil(32) {
            body.extend(self.random.random::<u32>().to_le_bytes());
        }
    }

    fn append_count(&mut self, body: &mut Vec<u8>) {
        body.extend(self.random.random::<u32>().to_le_bytes());
    }

    fn append_noise(&mut self, body: &mut Vec<u8>, max_length: usize) {
        let mut noise = vec![0; self.random.random_range(0..=max_length)];
        self.random.fill_bytes(&mut noise);
        body.extend(noise);
    }

    /// Appends a serialized payload: discovery parameters or noise. Returns whether it contains a
    /// locator.
    fn append_payload(&mut self, body: &mut Vec<u8>) -> bool {
        match self.random.random_range(0..3) {
            0 => {
                body.extend([0, 3, 0, 0]);
                self.append_parameters(body)
            }
            1 => {
                let encoding = self.pick(&[[0, 0, 0, 0], [0, 1, 0, 0], [0, 7, 0, 0], [9, 9, 9, 9]]);
                body.extend(encoding);
                self.append_noise(body, 200);
                false
            }
            _ => {
                self.append_noise(body, 6);
                false
            }
        }
    }

    /// Appends a parameter list. Returns whether it contains a locator.
    fn append_parameters(&mut self, body: &mut Vec<u8>) -> bool {
        let mut has_locator = false;
        for _ in 0..self.random.random_range(0..12) {
            if self.random.random_bool(0.2) {
                body.extend(self.pick(&LOCATORS).to_le_bytes());
                body.extend(24u16.to_le_bytes());
                self.append_locator(body);
                has_locator = true;
                continue;
            }
            body.extend(self.pick(&PARAMETERS).to_le_bytes());
            let length = 4 * self.random.random_range(0..8u16);
            let is_wrong = self.random.random_bool(0.05);
            let announced_length = if is_wrong { self.small() } else { length };
            body.extend(announced_length.to_le_bytes());
            let text_length = self.pick(&[0, 1, 4, u32::from(length), 1 << 31, u32::MAX]);
            let mut value = vec![0; usize::from(length)];
            self.random.fill_bytes(&mut value);
            if self.random.random_bool(0.5) && value.len() >= 4 {
                value[..4].copy_from_slice(&text_length.to_le_bytes());
            }
            if self.random.random_bool(0.3) && value.len() >= 16 {
                let guid = self.pick(&self.senders.clone());
                value[..16].copy_from_slice(&guid);
            }
            body.extend(value);
        }
        if self.random.random_bool(0.9) {
            // PID_SENTINEL, the end of the list.
            body.extend([1, 0, 0, 0]);
        }
        has_locator
    }

    /// Appends a locator with a loopback address. Its kind is UDPv4, invalid or unsupported.
    fn append_locator(&mut self, body: &mut Vec<u8>) {
        let kind: i32 = self.pick(&[1, 1, 0, -1, 16]);
        body.extend(kind.to_le_bytes());
        body.extend(u32::from(self.small()).to_le_bytes());
        body.extend([0; 12]);
        body.extend([127, 0, 0, 1]);
    }
}
