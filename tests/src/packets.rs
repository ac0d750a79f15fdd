//! Packets of RTPS that are wrong: of the right form at first sight, so that they get far, with random
//! numbers where a packet says what follows, how much of it, and since when.

use rand::{Rng, RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

const ACKNACK: u8 = 0x06;
/// A writer says which samples it has.
pub const HEARTBEAT: u8 = 0x07;
/// A writer says which samples do not exist.
pub const GAP: u8 = 0x08;
const INFO_TS: u8 = 0x09;
const INFO_SRC: u8 = 0x0c;
const INFO_DST: u8 = 0x0e;
const INFO_REPLY: u8 = 0x0f;
/// A reader asks for parts of a sample.
pub const NACK_FRAG: u8 = 0x12;
const HEARTBEAT_FRAG: u8 = 0x13;
const DATA: u8 = 0x15;
/// A part of a sample.
pub const DATA_FRAG: u8 = 0x16;

/// The endpoints that every participant has: they tell of participants, writers, readers and topics,
/// and of who is alive.
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
/// The flag that every submessage has.
const LITTLE_ENDIAN: u8 = 1;
const ALL_READERS: [u8; 4] = [0; 4];

/// The parameters of discovery that hold neither a place in the network nor a list of them.
const PARAMETERS: [u16; 24] = [
    0x0002, 0x0004, 0x0005, 0x0007, 0x0015, 0x0016, 0x001a, 0x001b, 0x001d, 0x001f, 0x0021, 0x0023,
    0x0025, 0x002c, 0x0034, 0x0040, 0x0041, 0x0050, 0x0058, 0x005a, 0x0062, 0x0070, 0x0071, 0x0073,
];
/// Those that hold one, which is always this machine: no answer shall leave it.
const LOCATORS: [u16; 4] = [0x002f, 0x0031, 0x0032, 0x0048];

/// An endpoint as it is told apart from all others: its participant, and its number in it.
pub type Endpoint = [u8; 16];

/// A packet of one submessage, by a participant.
pub fn packet(sender: &Endpoint, kind: u8, body: &[u8]) -> Vec<u8> {
    let mut packet = header(sender);
    append_header(&mut packet, kind, LITTLE_ENDIAN, body.len() as u16);
    packet.extend(body);
    packet
}

fn header(sender: &Endpoint) -> Vec<u8> {
    // RTPS 2.4, by RustDDS as it says.
    [&b"RTPS"[..], &[2, 4, 1, 18], &sender[..12]].concat()
}

fn append_header(packet: &mut Vec<u8>, kind: u8, flags: u8, length: u16) {
    packet.extend([kind, flags]);
    packet.extend(length.to_le_bytes());
}

/// Random packets; the same seed, the same packets.
pub struct Packets {
    random: ChaCha8Rng,
    senders: Vec<Endpoint>,
    receivers: Vec<Endpoint>,
}

impl Packets {
    /// Packets as if from one of the senders to one of the receivers, some of them damaged.
    pub fn new(seed: u64, senders: &[Endpoint], receivers: &[Endpoint]) -> Packets {
        Packets {
            random: ChaCha8Rng::seed_from_u64(seed),
            senders: senders.to_vec(),
            receivers: receivers.to_vec(),
        }
    }

    /// Another packet.
    pub fn draw(&mut self) -> Vec<u8> {
        let mut sender = self.pick(&self.senders.clone());
        if self.random.random_bool(0.2) {
            // Nobody knows this one.
            self.random.fill_bytes(&mut sender[..12]);
        }
        let mut packet = header(&sender);
        let mut is_open = true;
        for _ in 0..self.random.random_range(1..=4) {
            is_open &= !self.append_submessage(&mut packet, &sender);
        }
        match self.random.random_range(0..8) {
            0 => packet.truncate(self.random.random_range(0..=packet.len())),
            // A place in the network stays this machine.
            1..=3 if is_open => {
                for _ in 0..self.random.random_range(1..=3) {
                    let place = self.random.random_range(0..packet.len());
                    packet[place] ^= 1 << self.random.random_range(0..8);
                }
            }
            _ => {}
        }
        packet
    }

    /// Appends a submessage; whether it holds a place in the network.
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
        // Of the other bits, some have a meaning.
        let any = self.random.random();
        let mut flags = LITTLE_ENDIAN | self.pick(&[0, 0, 2, 4, 6, 8, any]);
        let mut body = Vec::new();
        let mut holds_places = false;
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
                    holds_places |= self.append_parameters(&mut body);
                }
                holds_places |= self.append_payload(&mut body);
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
                    holds_places |= self.append_parameters(&mut body);
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
                holds_places = true;
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
        holds_places
    }

    fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        *all.choose(&mut self.random).expect("there is something to choose from")
    }

    /// The reader and the writer that a submessage is between, one of which sends it.
    fn append_endpoints(&mut self, body: &mut Vec<u8>, sender: &Endpoint, by_writer: bool) {
        let receiver = self.pick(&self.receivers.clone());
        for owner in if by_writer { [receiver, *sender] } else { [*sender, receiver] } {
            let number = match self.random.random_range(0..4) {
                0 => self.pick(&BUILT_IN),
                1 => ALL_READERS,
                _ => [owner[12], owner[13], owner[14], owner[15]],
            };
            body.extend(number);
        }
    }

    /// A sequence number: mostly one that may be.
    fn append_number(&mut self, body: &mut Vec<u8>) {
        let most = i64::MAX;
        let number = match self.random.random_range(0..4) {
            0 => self.pick(&[0, -1, i64::MIN, i64::MIN + 1, most, most - 1]),
            _ => self.random.random_range(0..=100),
        };
        body.extend(((number >> 32) as i32).to_le_bytes());
        body.extend((number as u32).to_le_bytes());
    }

    /// A size, or the number of a fragment.
    fn append_size(&mut self, body: &mut Vec<u8>) {
        let most = u32::MAX;
        let size = match self.random.random_range(0..4) {
            0 => self.pick(&[most, most - 1, most / 2, 1, 0]),
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

    fn append_noise(&mut self, body: &mut Vec<u8>, most: usize) {
        let mut noise = vec![0; self.random.random_range(0..=most)];
        self.random.fill_bytes(&mut noise);
        body.extend(noise);
    }

    /// What a writer writes: discovery, or anything; whether it holds a place in the network.
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

    /// A list of parameters; whether it holds a place in the network.
    fn append_parameters(&mut self, body: &mut Vec<u8>) -> bool {
        let mut holds_places = false;
        for _ in 0..self.random.random_range(0..12) {
            if self.random.random_bool(0.2) {
                body.extend(self.pick(&LOCATORS).to_le_bytes());
                body.extend(24u16.to_le_bytes());
                self.append_locator(body);
                holds_places = true;
                continue;
            }
            body.extend(self.pick(&PARAMETERS).to_le_bytes());
            let length = 4 * self.random.random_range(0..8u16);
            let is_wrong = self.random.random_bool(0.05);
            let said = if is_wrong { self.small() } else { length };
            body.extend(said.to_le_bytes());
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
            body.extend([1, 0, 0, 0]);
        }
        holds_places
    }

    /// A port of this machine, or of no network that there is.
    fn append_locator(&mut self, body: &mut Vec<u8>) {
        let kind: i32 = self.pick(&[1, 1, 0, -1, 16]);
        body.extend(kind.to_le_bytes());
        body.extend(u32::from(self.small()).to_le_bytes());
        body.extend([0; 12]);
        body.extend([127, 0, 0, 1]);
    }
}
