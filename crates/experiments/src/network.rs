//! An emulated unreliable network between two hosts on this machine: two network namespaces with a
//! TAP device each, and a relay between the devices that loses, duplicates, delays and reorders
//! frames.
//!
//! Needs root and Linux. No packet leaves the two namespaces.

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

/// Buffer size for an Ethernet frame without its checksum, in bytes; larger than the MTU of 1500.
const BUFFER_SIZE: usize = 2048;

/// The faults that the network injects. Duplication is drawn independently for each frame; loss and
/// delay are drawn independently for each copy of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// Probability that a copy of a frame is lost, from 0 to 1.
    pub loss: f64,
    /// Probability that a frame is duplicated, from 0 to 1.
    pub repetition: f64,
    /// Maximum delay of a copy. Delays are uniformly distributed from zero to this value, so frames
    /// can arrive out of order.
    pub delay: Duration,
}

/// Frame counts, summed over both directions.
#[derive(Clone, Copy, Debug)]
pub struct Traffic {
    /// Frames sent.
    pub frames: u64,
    /// Frames of which no copy was delivered, because of loss or a cut.
    pub lost: u64,
    /// Frames that were delivered twice.
    pub repeated: u64,
}

/// The live counters behind [`Traffic`].
#[derive(Debug, Default)]
struct Counters {
    frames: AtomicU64,
    lost: AtomicU64,
    repeated: AtomicU64,
}

/// A host of the network: a network namespace, which is removed when this value is dropped.
pub struct Host {
    /// The process that keeps the namespace alive.
    holder: Child,
}

/// A handle to the network namespace of a [`Host`], which a thread of this process can enter.
pub struct Door(File);

impl Door {
    /// Moves the calling thread to the host. Sockets that the thread opens and threads that it
    /// starts from now on belong to the host.
    ///
    /// # Errors
    ///
    /// Returns an error if this process lacks the required permission.
    pub fn enter(&self) -> anyhow::Result<()> {
        let kind = Some(LinkNameSpaceType::Network);
        Ok(move_into_link_name_space(self.0.as_fd(), kind)?)
    }
}

/// Two hosts and the relay between them. They are removed when this value is dropped.
pub struct Network {
    hosts: [Host; 2],
    is_cut: Arc<AtomicBool>,
    counters: Arc<Counters>,
}

impl Network {
    /// Creates two hosts that are connected through a network with these faults. `seed` determines
    /// which frames are affected.
    ///
    /// # Errors
    ///
    /// Returns an error if this process lacks the required permission, or if the machine does not
    /// support TAP devices.
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

    /// Checks that this process can create such a network on this machine.
    ///
    /// # Errors
    ///
    /// Returns a description of the first requirement that is not met.
    pub fn check_requirements() -> Result<(), String> {
        let is_installed = |program: &str| {
            let run = Command::new(program).arg("--version").stdout(Stdio::null()).status();
            run.is_ok_and(|status| status.success())
        };
        if !std::path::Path::new("/dev/net/tun").exists() {
            return Err("/dev/net/tun not found: load the kernel module tun".into());
        }
        if !is_installed("unshare") || !is_installed("nsenter") {
            return Err("unshare or nsenter not found: install util-linux".into());
        }
        if Command::new("ip").arg("-V").stdout(Stdio::null()).status().is_err() {
            return Err("ip not found: install iproute2".into());
        }
        let probe = Command::new("unshare").args(["--net", "true"]).stderr(Stdio::null()).status();
        match probe.is_ok_and(|status| status.success()) {
            true => Ok(()),
            false => Err("no permission to create network namespaces: run as root".into()),
        }
    }

    /// Returns both hosts.
    pub fn hosts(&self) -> &[Host; 2] {
        &self.hosts
    }

    /// Cuts the network (`true`), which then drops every frame, or restores it (`false`).
    pub fn set_partitioned(&self, is_cut: bool) {
        self.is_cut.store(is_cut, Ordering::Relaxed);
    }

    /// Returns the frame counts so far.
    pub fn traffic(&self) -> Traffic {
        let Counters { frames, lost, repeated } = &*self.counters;
        let number = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Traffic { frames: number(frames), lost: number(lost), repeated: number(repeated) }
    }
}

impl Host {
    fn new() -> anyhow::Result<Host> {
        // The child is killed on drop. If this process crashes, sleep ends after two hours.
        let mut command = Command::new("unshare");
        command.args(["--net", "--kill-child", "sleep", "7200"]).stdin(Stdio::null());
        let holder = command.spawn().context("cannot run unshare (Debian: util-linux)")?;
        let host = Host { holder };
        // unshare creates the namespace shortly after it starts.
        let end = Instant::now() + Duration::from_secs(10);
        while !host.has_own_namespace()? {
            ensure!(Instant::now() < end, "unshare created no network namespace: run as root");
            thread::sleep(Duration::from_millis(5));
        }
        host.run(&["ip", "link", "set", "lo", "up"])?;
        Ok(host)
    }

    fn namespace(&self) -> String {
        format!("/proc/{}/ns/net", self.holder.id())
    }

    /// Returns a handle with which a thread of this process can enter the host.
    ///
    /// # Errors
    ///
    /// Returns an error if the process that holds the namespace has exited.
    pub fn door(&self) -> anyhow::Result<Door> {
        Ok(Door(File::open(self.namespace())?))
    }

    fn has_own_namespace(&self) -> anyhow::Result<bool> {
        Ok(std::fs::read_link(self.namespace())? != std::fs::read_link("/proc/self/ns/net")?)
    }

    /// Returns a command that runs a program on this host.
    pub fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new("nsenter");
        command.arg(format!("--net={}", self.namespace())).arg("--").arg(program);
        command
    }

    fn run(&self, command: &[&str]) -> anyhow::Result<()> {
        run(self.command(command[0]).args(&command[1..]))
    }

    /// Creates the host's TAP device with the address 10.77.0.`number`. The device is opened in the
    /// namespace of this process, for the relay, and then moved to the host.
    fn attach(&self, number: u8) -> anyhow::Result<Arc<SyncDevice>> {
        let name = format!("evac{}", self.holder.id());
        let device = DeviceBuilder::new().name(&name).layer(Layer::L2).build_sync();
        let device = device.with_context(|| format!("cannot create the TAP device {name}"))?;
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
    let output = command.stdin(Stdio::null()).output();
    let output = output.context("cannot run ip or nsenter (Debian: iproute2, util-linux)")?;
    let error = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{command:?} failed ({}): {error}", output.status);
    Ok(())
}

/// A frame to forward: due time, sequence number within its direction, and bytes. Reversed, so that
/// a [`BinaryHeap`] pops the earliest frame first.
type Frame = Reverse<(Instant, u64, Vec<u8>)>;

/// One direction of the network.
struct Relay {
    is_cut: Arc<AtomicBool>,
    counters: Arc<Counters>,
    faults: Faults,
}

impl Relay {
    /// Reads frames from a host until the device is closed, and schedules the copies to deliver.
    fn receive(
        &self,
        source: &SyncDevice,
        mut random: impl Rng,
        mut send: impl FnMut(Frame) -> bool,
    ) {
        let Faults { loss, repetition, delay } = self.faults;
        let mut buffer = vec![0; BUFFER_SIZE];
        let mut number = 0;
        while let Ok(length) = source.recv(&mut buffer) {
            let mut delivered = 0;
            for _ in 0..1 + usize::from(random.random_bool(repetition)) {
                let is_lost = random.random_bool(loss);
                let delay = delay.mul_f64(random.random());
                if is_lost || self.is_cut.load(Ordering::Relaxed) {
                    continue;
                }
                number += 1;
                delivered += 1;
                let frame = (Instant::now() + delay, number, buffer[..length].to_vec());
                if !send(Reverse(frame)) {
                    return;
                }
            }
            let Counters { frames, lost, repeated } = &*self.counters;
            frames.fetch_add(1, Ordering::Relaxed);
            match delivered {
                0 => lost.fetch_add(1, Ordering::Relaxed),
                1 => 0,
                _ => repeated.fetch_add(1, Ordering::Relaxed),
            };
        }
    }
}

/// Forwards each frame when it is due, until the sender disconnects.
fn send_when_due(sink: &SyncDevice, frames: &Receiver<Frame>) {
    let mut scheduled: BinaryHeap<Frame> = BinaryHeap::new();
    loop {
        let next = match scheduled.peek() {
            None => frames.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(Reverse((due, _, _))) => {
                frames.recv_timeout(due.saturating_duration_since(Instant::now()))
            }
        };
        match next {
            Ok(frame) => scheduled.push(frame),
            Err(RecvTimeoutError::Timeout) => {
                if let Some(Reverse((_, _, frame))) = scheduled.pop() {
                    // Sending fails only if the host has been removed.
                    let _ = sink.send(&frame);
                }
            }
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}
