//! Measures the round-trip time of a step and of its two baselines: a plain ros2-client service and
//! a bare UDP datagram.

use std::{
    net::UdpSocket,
    process::{Child, Command},
    time::{Duration, Instant},
};

use evac_msgs::{Reset, Step, reset, step};
use experiments::{Nodes, TIMEOUT};
use ros_interfaces::{RosService, sensor_msgs::Image, std_msgs::Header};
use ros_runtime::{
    discovery::Discovery,
    security::{EnclaveName, Security},
};
use ros2_client::{
    Client, Context, Name, Node, NodeName, NodeOptions, ServiceMapping,
    qos::{History, QosProfile},
};

use crate::quantile::percentile;

const ROUNDS: usize = 8;
const CALLS_A_ROUND: u32 = 4000;
/// RustDDS clears its caches for the first time after 6 s; until then its memory grows.
const WARM_UP: Duration = Duration::from_secs(7);
const UDP_PORT_VARIABLE: &str = "EVAC_BENCHMARK_PORT";
const PLAIN_SERVICE: &str = "/plain_step";
const PLAIN_REQUEST: step::Request = step::Request { episode: 1, step: 1, action: 3 };

/// Percentiles of the round-trip time, in microseconds.
pub struct Percentiles {
    pub p50: f64,
    pub p99: f64,
    pub p999: f64,
}

impl Percentiles {
    fn of(mut values: Vec<f64>) -> Percentiles {
        Percentiles {
            p50: percentile(&mut values, 0.5),
            p99: percentile(&mut values, 0.99),
            p999: percentile(&mut values, 0.999),
        }
    }
}

/// Round-trip times between two processes on this machine.
pub struct RoundTripFigures {
    /// Bare UDP: a request of 16 bytes and a reply of 480 bytes.
    pub udp: Percentiles,
    /// ros2-client's asynchronous client and server, with the messages and QoS of a step.
    pub plain: Percentiles,
    /// A step of `sim_node`.
    pub step: Percentiles,
}

pub fn measure() -> anyhow::Result<RoundTripFigures> {
    let mut nodes = Nodes::new();
    // ros2-client's Spinner subscribes to /clock. Without this remapping, sim_node would also send
    // the clock to the two nodes of the plain service on every step, which would slow down steps.
    let private_clock = "/clock:=/sim_node/clock";
    let arguments = ["--ros-args", "-r", private_clock, "-p", "max_steps:=1000000000"];
    nodes.start_beside("sim_node", "sim_node", &arguments);
    // The plain client is created before our own node and dropped after it: our node silences
    // RustDDS, which logs spurious errors when a participant shuts down.
    let (plain, plain_node) = plain_client(&nodes.discovery(Security::Off))?;
    let mut node = nodes.client();
    let own = std::env::current_exe()?;
    let _plain_server = KillOnDrop(nodes.command(&own).arg("plain-server").spawn()?);
    let udp = Udp::new(&mut nodes.command(&own))?;

    let steps = node.create_client::<Step>("step")?;
    let resets = node.create_client::<Reset>("reset")?;
    node.block_on(steps.wait_until_ready(Some(TIMEOUT)))?;
    let reset = reset::Request { request: 1, seed: 1, scenario: "three_cylinders".into() };
    let mut latest = node.block_on(resets.call(reset, Some(TIMEOUT)))?;
    anyhow::ensure!(latest.success, "{}", latest.message);
    futures::executor::block_on(plain.wait_for_service(&plain_node));
    // A server cannot tell whether the client's reply reader is matched, so its first replies may
    // be lost.
    let first_call =
        || tokio::time::timeout(Duration::from_secs(1), plain.async_call_service(PLAIN_REQUEST));
    while node.block_on(async { first_call().await.is_err() }) {}

    let (mut udp_us, mut plain_us, mut step_us) = (Vec::new(), Vec::new(), Vec::new());
    let mut number = 0;
    let mut seed = 1;
    let mut call_step = || -> anyhow::Result<f64> {
        number += 1;
        let request =
            step::Request { episode: latest.episode, step: number, action: (number % 7) as u8 };
        let started = Instant::now();
        let response = node.block_on(steps.call(request, Some(TIMEOUT)))?;
        let time = started.elapsed().as_secs_f64() * 1e6;
        anyhow::ensure!(response.success, "{}", response.message);
        if response.terminated || response.truncated {
            (number, seed) = (0, seed + 1);
            let scenario = "three_cylinders".to_owned();
            let request = reset::Request { request: seed, seed, scenario };
            latest = node.block_on(resets.call(request, Some(TIMEOUT)))?;
        }
        Ok(time)
    };
    let started = Instant::now();
    while started.elapsed() < WARM_UP {
        for _ in 0..1000 {
            call_step()?;
            call_plain(&plain)?;
        }
    }
    for _ in 0..ROUNDS {
        for _ in 0..CALLS_A_ROUND {
            udp_us.push(udp.call()?);
        }
        for _ in 0..CALLS_A_ROUND {
            plain_us.push(call_plain(&plain)?);
        }
        for _ in 0..CALLS_A_ROUND {
            step_us.push(call_step()?);
        }
    }
    Ok(RoundTripFigures {
        udp: Percentiles::of(udp_us),
        plain: Percentiles::of(plain_us),
        step: Percentiles::of(step_us),
    })
}

/// A child process that is killed when this value is dropped.
struct KillOnDrop(Child);

impl Drop for KillOnDrop {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A UDP client and its echo process.
struct Udp {
    socket: UdpSocket,
    _echo: KillOnDrop,
}

impl Udp {
    fn new(command: &mut Command) -> anyhow::Result<Udp> {
        let socket = UdpSocket::bind("127.0.0.1:0")?;
        socket.set_read_timeout(Some(TIMEOUT))?;
        let port = socket.local_addr()?.port().to_string();
        let echo = KillOnDrop(command.arg("udp-echo").env(UDP_PORT_VARIABLE, port).spawn()?);
        // The echo process announces its address with its first datagram.
        let (_, address) = socket.recv_from(&mut [0; 512])?;
        socket.connect(address)?;
        Ok(Udp { socket, _echo: echo })
    }

    /// Returns the time of one round trip, in microseconds.
    fn call(&self) -> anyhow::Result<f64> {
        let started = Instant::now();
        self.socket.send(&[0; 16])?;
        self.socket.recv(&mut [0; 512])?;
        Ok(started.elapsed().as_secs_f64() * 1e6)
    }
}

/// Runs the remote end of the UDP round trips; does not return unless the socket fails.
pub fn udp_echo() -> anyhow::Result<()> {
    let port: u16 = std::env::var(UDP_PORT_VARIABLE)?.parse()?;
    let socket = UdpSocket::bind("127.0.0.1:0")?;
    socket.connect(("127.0.0.1", port))?;
    socket.send(&[0])?;
    loop {
        socket.recv(&mut [0; 512])?;
        socket.send(&[0; 480])?;
    }
}

fn services() -> QosProfile {
    QosProfile::publisher_default().history(History::KeepLast { depth: 10 })
}

fn plain_node(discovery: &Discovery, name: &str) -> anyhow::Result<Node> {
    let context = Context::from_domain_participant(discovery.participant(Default::default())?)?;
    let mut node = context.new_node(NodeName::new("/", name)?, NodeOptions::new())?;
    // Without a running Spinner, a ros2-client node does not discover remote endpoints.
    let spinner = node.spinner()?;
    std::thread::spawn(move || futures::executor::block_on(spinner.spin()));
    Ok(node)
}

type PlainClient = Client<step::Request, step::Response>;

fn plain_client(discovery: &Discovery) -> anyhow::Result<(PlainClient, Node)> {
    let mut node = plain_node(discovery, "plain_client")?;
    let client = node.create_client(
        ServiceMapping::Enhanced,
        &Name::parse(PLAIN_SERVICE)?,
        &Step::type_name(),
        services(),
        services(),
    )?;
    Ok((client, node))
}

fn call_plain(client: &PlainClient) -> anyhow::Result<f64> {
    let started = Instant::now();
    futures::executor::block_on(client.async_call_service(PLAIN_REQUEST))?;
    Ok(started.elapsed().as_secs_f64() * 1e6)
}

/// Runs the remote end of the plain service, which replies with an image, as a step does.
pub fn plain_server() -> anyhow::Result<()> {
    let mut node =
        plain_node(&Discovery::from_environment(&EnclaveName::default())?, "plain_server")?;
    let server = node.create_server::<step::Request, step::Response>(
        ServiceMapping::Enhanced,
        &Name::parse(PLAIN_SERVICE)?,
        &Step::type_name(),
        services(),
        services(),
    )?;
    let image = Image {
        header: Header { frame_id: "camera_optical_frame".into(), ..Header::default() },
        width: 20,
        height: 7,
        encoding: "rgb8".into(),
        step: 60,
        data: vec![128; 420],
        ..Image::default()
    };
    let response = step::Response { success: true, image, ..step::Response::default() };
    futures::executor::block_on(async {
        loop {
            let (id, _) = server.async_receive_request().await?;
            server.async_send_response(id, response.clone()).await?;
        }
    })
}
