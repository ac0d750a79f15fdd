//! The real nodes as processes of their own, in a DDS domain of their own, on loopback.

use std::{
    collections::HashMap,
    fs::File,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{Mutex, MutexGuard, OnceLock},
    time::{Duration, Instant},
};

use crate::network::Host;
use evac_msgs::EpisodeStatus;
use ros_runtime::{
    Arguments, Node,
    corrections::is_corrected,
    discovery::{Discovery, Range},
    node::reliable,
    security::Security,
};

/// What is not there after this time never comes; a bound for hanging, not a measure of speed.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// The root of the repository.
pub fn repository() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).expect("this package lies in the repository")
}

/// A node's program, built from what is here now.
pub fn binary(name: &str) -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let directory = BUILT.get_or_init(|| {
        // The tests' own program is in target/PROFILE/deps, the benchmark's in target/PROFILE.
        let own = std::env::current_exe().expect("this program has a path");
        let parent = own.parent().expect("a program lies in a directory");
        let directory = match parent.file_name() {
            Some(name) if name == "deps" => parent.parent().expect("target/PROFILE").to_owned(),
            _ => parent.to_owned(),
        };
        let profile = match directory.file_name().and_then(|name| name.to_str()) {
            Some("debug") | None => "dev",
            Some(profile) => profile,
        };
        let mut build = Command::new(env!("CARGO"));
        build
            .args(["build", "--quiet", "--bins", "--profile", profile])
            .args(["--package", "sim_node", "--package", "agent_node", "--package", "launcher"])
            .current_dir(repository());
        // What cargo says to a test of its package has ring, which security stands on, built anew.
        for (name, _) in std::env::vars().filter(|(name, _)| is_of_a_package(name)) {
            build.env_remove(name);
        }
        if cfg!(feature = "security") {
            build.args(["--features", "security"]);
        }
        let built = build.status();
        assert!(built.expect("cargo runs").success(), "the nodes cannot be built");
        directory
    });
    directory.join(name)
}

/// A node's arguments.
fn arguments<'a>(command: Option<&'a str>, parameters: &[&'a str]) -> Vec<&'a str> {
    let parameters = parameters.iter().flat_map(|parameter| ["-p", *parameter]);
    command.into_iter().chain(["--ros-args"]).chain(parameters).collect()
}

fn is_of_a_package(variable: &str) -> bool {
    ["CARGO_MANIFEST_", "CARGO_PKG_"].iter().any(|prefix| variable.starts_with(prefix))
}

/// A domain and the processes in it, which end with it.
///
/// One test at a time: the machine may be small, and the nodes are real.
pub struct Nodes {
    domain_id: u16,
    processes: HashMap<String, Process>,
    /// What the environment of every process has besides.
    variables: Vec<(String, String)>,
    directory: tempfile::TempDir,
    started: u32,
    _turn: MutexGuard<'static, ()>,
}

struct Process {
    child: Child,
    log: PathBuf,
}

impl Nodes {
    /// A domain that no other test of this machine uses just now.
    pub fn new() -> Nodes {
        static TURN: Mutex<()> = Mutex::new(());
        static COUNT: Mutex<u32> = Mutex::new(0);
        let turn = TURN.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let mut count = COUNT.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        *count += 1;
        // From 102 on, the ports of RTPS lie where Linux takes those of outgoing connections.
        let domain_id = 1 + (std::process::id() * 7 + *count) % 101;
        Nodes {
            domain_id: domain_id as u16,
            processes: HashMap::new(),
            variables: Vec::new(),
            directory: tempfile::tempdir().expect("a temporary directory"),
            started: 0,
            _turn: turn,
        }
    }

    /// A directory that goes with the test.
    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// Sets a variable in the environment of everything that is started from now on.
    pub fn set_variable(&mut self, name: &str, value: &str) {
        self.variables.push((name.to_owned(), value.to_owned()));
    }

    /// A command in this domain.
    pub fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command
            .env("ROS_DOMAIN_ID", self.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .envs(self.variables.iter().map(|(name, value)| (name, value)))
            // The scripts then leave the build as it is, too.
            .envs((!is_corrected()).then_some(("EVAC_UNCORRECTED", "1")))
            .stdin(Stdio::null());
        command
    }

    /// One of the peers in Python.
    pub fn peer(&self, name: &str) -> Command {
        let python = std::env::var("EVAC_PYTHON")
            .expect("EVAC_PYTHON names a python with the peers: run launch_scripts/test.sh");
        let mut peer = self.command(python);
        peer.arg(repository().join("tests/peers").join(name));
        peer
    }

    /// Runs a command to its end: its status, and what it wrote to standard output and error.
    pub fn run(&self, command: &mut Command) -> (ExitStatus, String, String) {
        let open = |name: &str| self.path(&format!("{name}-{}", self.domain_id));
        let (out, err) = (open("stdout"), open("stderr"));
        let create = |path: &Path| File::create(path).expect("a file for the output");
        let mut child = command
            .stdout(create(&out))
            .stderr(create(&err))
            .spawn()
            .unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let end = Instant::now() + 5 * PATIENCE;
        let read = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
        let status = loop {
            if let Some(status) = child.try_wait().expect("it is our child") {
                break status;
            }
            if Instant::now() > end {
                let _ = child.kill();
                panic!("{command:?} does not end:\n{}", read(&err));
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        (status, read(&out), read(&err))
    }

    /// How a participant of this process joins the domain.
    pub fn discovery(&self, security: Security) -> Discovery {
        Discovery { domain_id: self.domain_id, range: Range::Localhost, security }
    }

    /// A node in this process, as a client beside the others.
    pub fn client(&self) -> Node {
        self.client_with(Security::Off)
    }

    /// As [`Nodes::client`], with keys.
    pub fn client_with(&self, security: Security) -> Node {
        Node::with_discovery(
            "test_client",
            &Arguments::default(),
            evac_msgs::DEFINITIONS,
            self.discovery(security),
        )
        .expect("a node")
    }

    /// The memory that a node holds, in MB (of 10^6 bytes).
    pub fn memory_mb(&mut self, name: &str) -> f64 {
        let status = format!("/proc/{}/status", self.process(name).child.id());
        let status = std::fs::read_to_string(status).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
        kibibytes.map_or(f64::NAN, |kibibytes| kibibytes * 1024.0 / 1e6)
    }

    /// How much memory a node may take, in bytes; none if as much as it likes.
    pub fn memory_limit(&mut self, name: &str) -> Option<u64> {
        let limits = format!("/proc/{}/limits", self.process(name).child.id());
        let limits = std::fs::read_to_string(limits).ok()?;
        let line = limits.lines().find_map(|line| line.strip_prefix("Max data size"))?;
        line.split_whitespace().next()?.parse().ok()
    }

    /// How many files, sockets and the like a node has open; none once it has ended.
    pub fn handles(&mut self, name: &str) -> Option<usize> {
        let handles = format!("/proc/{}/fd", self.process(name).child.id());
        Some(std::fs::read_dir(handles).ok()?.count())
    }

    /// Waits for a node's end: the most memory that it was seen to hold, in MB.
    pub fn greatest_memory_mb(&mut self, name: &str, patience: Duration) -> f64 {
        let end = Instant::now() + patience;
        let mut greatest = 0f64;
        while self.process(name).child.try_wait().expect("it is our child").is_none() {
            assert!(Instant::now() < end, "{name} does not end:\n{}", self.log(name));
            // Not a number once the process has ended, which max leaves out.
            greatest = greatest.max(self.memory_mb(name));
            std::thread::sleep(Duration::from_millis(100));
        }
        greatest
    }

    /// Starts `sim_node` with parameters, such as `max_steps:=100`.
    pub fn start_simulator(&mut self, parameters: &[&str]) {
        self.start("sim_node", None, parameters);
    }

    /// Starts `agent_node` with a command and parameters.
    pub fn start_agent(&mut self, command: &str, parameters: &[&str]) {
        self.start("agent_node", Some(command), parameters);
    }

    /// Starts `agent_node` with a command and a parameter file.
    pub fn start_agent_with_file(&mut self, command: &str, file: &Path) {
        let file = file.to_str().expect("a path in Unicode");
        self.start_with("agent_node", &[command, "--ros-args", "--params-file", file]);
    }

    fn start(&mut self, name: &str, command: Option<&str>, parameters: &[&str]) {
        self.start_with(name, &arguments(command, parameters));
    }

    fn start_with(&mut self, name: &str, arguments: &[&str]) {
        self.start_beside(name, name, arguments);
    }

    /// Starts a node's program with any arguments, as a process known by `name`.
    pub fn start_beside(&mut self, program: &str, name: &str, arguments: &[&str]) {
        let process = self.command(binary(program));
        self.spawn(process, name, arguments);
    }

    /// Starts `sim_node` with parameters on a host of its own, as a process known by `name`.
    pub fn start_simulator_on(&mut self, host: &Host, name: &str, parameters: &[&str]) {
        self.start_on(host, "sim_node", name, &arguments(None, parameters));
    }

    /// As [`Nodes::start_simulator_on`], but `agent_node` with a command.
    pub fn start_agent_on(&mut self, host: &Host, name: &str, command: &str, parameters: &[&str]) {
        self.start_on(host, "agent_node", name, &arguments(Some(command), parameters));
    }

    fn start_on(&mut self, host: &Host, program: &str, name: &str, arguments: &[&str]) {
        let mut process = host.command(binary(program));
        process
            .env("ROS_DOMAIN_ID", self.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
            .stdin(Stdio::null());
        self.spawn(process, name, arguments);
    }

    fn spawn(&mut self, mut process: Command, name: &str, arguments: &[&str]) {
        self.started += 1;
        let log = self.path(&format!("{name}-{}.log", self.started));
        process.args(arguments);
        let output = File::options().append(true).create(true).open(&log).expect("a log file");
        process.stdout(output.try_clone().expect("a second handle")).stderr(output);
        let child = process.spawn().expect("the node starts");
        let previous = self.processes.insert(name.to_owned(), Process { child, log });
        if let Some(mut previous) = previous {
            let _ = previous.child.kill();
            let _ = previous.child.wait();
        }
    }

    /// Ends a node without any chance to take leave.
    pub fn kill(&mut self, name: &str) {
        let process = self.process(name);
        process.child.kill().expect("the node is there");
        process.child.wait().expect("the node is our child");
    }

    /// The number of a node's process.
    pub fn process_id(&mut self, name: &str) -> u32 {
        self.process(name).child.id()
    }

    /// Sends a signal, such as `INT`.
    pub fn signal(&mut self, name: &str, signal: &str) {
        let pid = self.process_id(name).to_string();
        let sent = Command::new("kill").args(["-s", signal, &pid]).status();
        assert!(sent.expect("kill runs").success());
    }

    /// Waits for a node's end.
    pub fn wait(&mut self, name: &str, patience: Duration) -> ExitStatus {
        let end = Instant::now() + patience;
        loop {
            if let Some(status) = self.process(name).child.try_wait().expect("it is our child") {
                return status;
            }
            let log = self.log(name);
            assert!(Instant::now() < end, "{name} does not end within {patience:?}:\n{log}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// How a node has ended, if it has.
    pub fn ended(&mut self, name: &str) -> Option<ExitStatus> {
        self.process(name).child.try_wait().expect("it is our child")
    }

    /// Waits for a node's end, which must be a success.
    pub fn succeed(&mut self, name: &str, patience: Duration) {
        let status = self.wait(name, patience);
        let log = self.log(name);
        assert!(status.success(), "{name} ended with {status}:\n{log}");
    }

    /// Waits until a node has said something.
    pub fn wait_for_log(&mut self, name: &str, text: &str) {
        let end = Instant::now() + PATIENCE;
        while !self.log(name).contains(text) {
            let log = self.log(name);
            assert!(Instant::now() < end, "{name} never says '{text}':\n{log}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until a node has done something.
    pub fn wait_until(&mut self, name: &str, is_done: impl Fn() -> bool) {
        let end = Instant::now() + PATIENCE;
        while !is_done() {
            assert!(Instant::now() < end, "{name} does nothing:\n{}", self.log(name));
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until the room has seen some more steps.
    pub fn wait_for_steps(&mut self, steps: u32) {
        let node = self.client();
        let subscription = node.create_subscription::<EpisodeStatus>("episode", reliable(10));
        let subscription = subscription.expect("a subscription");
        let seen = node.block_on(async {
            let mut seen = 0;
            while seen < steps {
                let next = tokio::time::timeout(PATIENCE, subscription.async_take()).await;
                match next {
                    Ok(Ok((status, _))) => seen += u32::from(status.step > 0),
                    Ok(Err(error)) => panic!("a status cannot be read: {error}"),
                    Err(_) => break,
                }
            }
            seen
        });
        assert_eq!(seen, steps, "the room does not go on:\n{}", self.log("agent_node"));
    }

    /// What a node has said so far.
    pub fn log(&mut self, name: &str) -> String {
        let file = File::open(&self.process(name).log).expect("the log was made at the start");
        let lines = BufReader::new(file).lines();
        lines.map_while(Result::ok).map(|line| line + "\n").collect()
    }

    fn process(&mut self, name: &str) -> &mut Process {
        self.processes.get_mut(name).expect("the node was started")
    }
}

impl Default for Nodes {
    fn default() -> Nodes {
        Nodes::new()
    }
}

impl Drop for Nodes {
    fn drop(&mut self) {
        for process in self.processes.values_mut() {
            let _ = process.child.kill();
            let _ = process.child.wait();
        }
    }
}
