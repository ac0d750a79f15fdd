//! Two hosts and a bad network between them, all on this machine: two network namespaces, a TAP
//! device in each, and a relay between the two that loses, repeats, delays and reorders frames.
//!
//! It takes root and Linux; no packet of it leaves the two namespaces.

use std::{
    cmp::Reverse,
    collections::BinaryHeap,
    fs::File,
    os::fd::AsFd,
    process::{Child, Command, Stdio},
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc::{Receiver, RecvTimeoutError, channel},
    },
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, ensure};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::thread::{LinkNameSpaceType, move_into_link_name_space};
use tun_rs::{DeviceBuilder, Layer, SyncDevice};

/// A frame of Ethernet without its checksum, and with room to spare.
const LONGEST_FRAME: usize = 2048;

/// What the network does to a frame; each chance is for every frame anew.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// The chance that it is lost.
    pub loss: f64,
    /// The chance that it comes twice.
    pub repetition: f64,
    /// The longest delay; each frame has its own, so they overtake each other.
    pub delay: Duration,
}

/// What has become of the frames so far, in both directions.
#[derive(Clone, Copy, Debug)]
pub struct Traffic {
    /// Frames that were sent.
    pub frames: u64,
    /// Those of them that did not arrive, not once, because of the losses or of a cut.
    pub lost: u64,
    /// Those that arrived twice.
    pub repeated: u64,
}

/// [`Traffic`] as it is counted.
#[derive(Debug, Default)]
struct Counters {
    frames: AtomicU64,
    lost: AtomicU64,
    repeated: AtomicU64,
}

/// One of the hosts.
pub struct Host {
    /// Holds the namespace.
    holder: Child,
}

/// A way to a [`Host`] for a thread of this process.
pub struct Door(File);

impl Door {
    /// Takes this thread to the host: its sockets from now on, and the threads that it starts.
    ///
    /// # Errors
    ///
    /// If this process may not.
    pub fn enter(&self) -> anyhow::Result<()> {
        let kind = Some(LinkNameSpaceType::Network);
        Ok(move_into_link_name_space(self.0.as_fd(), kind)?)
    }
}

/// The hosts and the relay, which end with this value.
pub struct Network {
    hosts: [Host; 2],
    is_cut: Arc<AtomicBool>,
    counters: Arc<Counters>,
}

impl Network {
    /// Two hosts that hear each other as the faults allow; the same seed, the same faults.
    ///
    /// # Errors
    ///
    /// If this process may not, or the machine has no such devices.
    pub fn new(faults: Faults, seed: u64) -> anyhow::Result<Network> {
        let hosts = [Host::new()?, Host::new()?];
        let is_cut = Arc::new(AtomicBool::new(false));
        let counters = Arc::new(Counters::default());
        let devices = [hosts[0].attach(1)?, hosts[1].attach(2)?];
        for (from, to) in [(0, 1), (1, 0)] {
            let (source, sink) = (devices[from].clone(), devices[to].clone());
            let random = ChaCha8Rng::seed_from_u64(2 * seed + from as u64);
            let relay = Relay { is_cut: is_cut.clone(), counters: counters.clone(), faults };
            let (sender, frames) = channel();
            thread::spawn(move || send_when_due(&sink, &frames));
            thread::spawn(move || {
                relay.receive(&source, random, |frame| sender.send(frame).is_ok());
            });
        }
        Ok(Network { hosts, is_cut, counters })
    }

    /// Whether this machine and this process can have such a network; if not, what is missing.
    pub fn is_possible() -> Result<(), String> {
        let is_there = |program: &str| {
            let run = Command::new(program).arg("--version").stdout(Stdio::null()).status();
            run.is_ok_and(|status| status.success())
        };
        if !std::path::Path::new("/dev/net/tun").exists() {
            return Err("there is no /dev/net/tun".into());
        }
        if !is_there("unshare") || !is_there("nsenter") {
            return Err("there is no util-linux".into());
        }
        if Command::new("ip").arg("-V").stdout(Stdio::null()).status().is_err() {
            return Err("there is no iproute2".into());
        }
        let apart = Command::new("unshare").args(["--net", "true"]).stderr(Stdio::null()).status();
        match apart.is_ok_and(|status| status.success()) {
            true => Ok(()),
            false => Err("this process may not make network namespaces: it is not root's".into()),
        }
    }

    /// The hosts.
    pub fn hosts(&self) -> &[Host; 2] {
        &self.hosts
    }

    /// Cuts the network, or mends it.
    pub fn set_cut(&self, is_cut: bool) {
        self.is_cut.store(is_cut, Ordering::Relaxed);
    }

    /// What has become of the frames so far.
    pub fn traffic(&self) -> Traffic {
        let Counters { frames, lost, repeated } = &*self.counters;
        let number = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Traffic { frames: number(frames), lost: number(lost), repeated: number(repeated) }
    }
}

impl Host {
    fn new() -> anyhow::Result<Host> {
        // It ends with this process, or in any case some day.
        let mut command = Command::new("unshare");
        command.args(["--net", "--kill-child", "sleep", "7200"]).stdin(Stdio::null());
        let holder = command.spawn().context("unshare (Debian: util-linux) does not run")?;
        let host = Host { holder };
        // unshare has made the namespace once it runs the other program.
        let end = Instant::now() + Duration::from_secs(10);
        while !host.is_apart()? {
            ensure!(Instant::now() < end, "there is no network namespace: are we root?");
            thread::sleep(Duration::from_millis(5));
        }
        host.run(&["ip", "link", "set", "lo", "up"])?;
        Ok(host)
    }

    fn namespace(&self) -> String {
        format!("/proc/{}/ns/net", self.holder.id())
    }

    /// What takes a thread of this process to this host.
    ///
    /// # Errors
    ///
    /// If the host is gone.
    pub fn door(&self) -> anyhow::Result<Door> {
        Ok(Door(File::open(self.namespace())?))
    }

    fn is_apart(&self) -> anyhow::Result<bool> {
        Ok(std::fs::read_link(self.namespace())? != std::fs::read_link("/proc/self/ns/net")?)
    }

    /// A command that runs on this host.
    pub fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new("nsenter");
        command.arg(format!("--net={}", self.namespace())).arg("--").arg(program);
        command
    }

    fn run(&self, command: &[&str]) -> anyhow::Result<()> {
        run(self.command(command[0]).args(&command[1..]))
    }

    /// Gives the host its place in the network.
    fn attach(&self, number: u8) -> anyhow::Result<Arc<SyncDevice>> {
        let name = format!("evac{}", self.holder.id());
        let device = DeviceBuilder::new().name(&name).layer(Layer::L2).build_sync();
        let device = device.context("there is no TAP device")?;
        run(Command::new("ip").args([
            "link",
            "set",
            &name,
            "netns",
            &self.holder.id().to_string(),
        ]))?;
        self.run(&["ip", "address", "add", &format!("10.77.0.{number}/24"), "dev", &name])?;
        self.run(&["ip", "link", "set", &name, "up"])?;
        self.run(&["ip", "route", "add", "224.0.0.0/4", "dev", &name])?;
        Ok(Arc::new(device))
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        let _ = self.holder.kill();
        let _ = self.holder.wait();
    }
}

fn run(command: &mut Command) -> anyhow::Result<()> {
    let output = command.stdin(Stdio::null()).output().context("there is no iproute2")?;
    let error = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{command:?} ended with {}: {error}", output.status);
    Ok(())
}

/// When a frame is sent on, its number among all of its direction, and its bytes.
type Frame = Reverse<(Instant, u64, Vec<u8>)>;

/// One direction of the network.
struct Relay {
    is_cut: Arc<AtomicBool>,
    counters: Arc<Counters>,
    faults: Faults,
}

impl Relay {
    /// Reads what a host sends, until the host is gone.
    fn receive(
        &self,
        source: &SyncDevice,
        mut random: impl Rng,
        mut send: impl FnMut(Frame) -> bool,
    ) {
        let Faults { loss, repetition, delay } = self.faults;
        let mut buffer = vec![0; LONGEST_FRAME];
        let mut number = 0;
        while let Ok(length) = source.recv(&mut buffer) {
            let mut arriving = 0;
            for _ in 0..1 + usize::from(random.random_bool(repetition)) {
                let is_lost = random.random_bool(loss);
                let delay = delay.mul_f64(random.random());
                if is_lost || self.is_cut.load(Ordering::Relaxed) {
                    continue;
                }
                number += 1;
                arriving += 1;
                let frame = (Instant::now() + delay, number, buffer[..length].to_vec());
                if !send(Reverse(frame)) {
                    return;
                }
            }
            let Counters { frames, lost, repeated } = &*self.counters;
            frames.fetch_add(1, Ordering::Relaxed);
            match arriving {
                0 => lost.fetch_add(1, Ordering::Relaxed),
                1 => 0,
                _ => repeated.fetch_add(1, Ordering::Relaxed),
            };
        }
    }
}

/// Sends frames on when they are due.
fn send_when_due(sink: &SyncDevice, frames: &Receiver<Frame>) {
    let mut waiting: BinaryHeap<Frame> = BinaryHeap::new();
    loop {
        let next = match waiting.peek() {
            None => frames.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(Reverse((due, _, _))) => {
                frames.recv_timeout(due.saturating_duration_since(Instant::now()))
            }
        };
        match next {
            Ok(frame) => waiting.push(frame),
            Err(RecvTimeoutError::Timeout) => {
                if let Some(Reverse((_, _, frame))) = waiting.pop() {
                    // A host that is gone hears nothing.
                    let _ = sink.send(&frame);
                }
            }
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}
