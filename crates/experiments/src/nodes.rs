//! The real nodes as child processes, in a separate DDS domain on the loopback interface.

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

/// The timeout for everything that a test waits for. It is generous, because it is meant to detect
/// hangs, not slowness.
pub const TIMEOUT: Duration = Duration::from_secs(60);

/// Returns the root of the repository.
pub fn repository() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.ancestors().nth(2).expect("the package is in crates/experiments")
}

/// Returns the path of a program (`sim_node`, `agent_node` or `evac`), built with the caller's
/// profile. The first call builds all three.
///
/// # Panics
///
/// Panics if the build fails.
pub fn binary(name: &str) -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let directory = BUILT.get_or_init(|| {
        // A test program is in target/PROFILE/deps, the benchmark in target/PROFILE.
        let own = std::env::current_exe().expect("this program has a path");
        let parent = own.parent().expect("a program is in a directory");
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
        // Cargo passes package variables to tests. If this build inherited them, cargo would
        // rebuild ring, a dependency of the security feature.
        for (name, _) in std::env::vars().filter(|(name, _)| is_package_variable(name)) {
            build.env_remove(name);
        }
        if cfg!(feature = "security") {
            build.args(["--features", "security"]);
        }
        let status = build.status();
        assert!(status.expect("cargo runs").success(), "the nodes cannot be built");
        directory
    });
    directory.join(name)
}

/// Returns the arguments of a node: its command, if any, then `--ros-args` with the parameters.
fn arguments<'a>(command: Option<&'a str>, parameters: &[&'a str]) -> Vec<&'a str> {
    let parameters = parameters.iter().flat_map(|parameter| ["-p", *parameter]);
    command.into_iter().chain(["--ros-args"]).chain(parameters).collect()
}

fn is_package_variable(variable: &str) -> bool {
    ["CARGO_MANIFEST_", "CARGO_PKG_"].iter().any(|prefix| variable.starts_with(prefix))
}

/// A DDS domain and the node processes in it, which are killed when this value is dropped.
///
/// At most one value exists at a time in a process: [`Nodes::new`] waits until the previous one is
/// dropped, so that tests with real nodes do not compete for the processor.
///
/// # Panics
///
/// The methods are meant for tests and panic if anything goes wrong, for example if a process
/// cannot be started or does not exit in time. The message then contains the log of the process.
pub struct Nodes {
    domain_id: u16,
    processes: HashMap<String, Process>,
    /// Additional environment variables for every process.
    variables: Vec<(String, String)>,
    directory: tempfile::TempDir,
    started: u32,
    _lock: MutexGuard<'static, ()>,
}

struct Process {
    child: Child,
    log: PathBuf,
}

impl Nodes {
    /// Creates an empty domain. Its ID is derived from the process ID, so that tests that run at
    /// the same time on this machine usually use different domains.
    pub fn new() -> Nodes {
        static LOCK: Mutex<()> = Mutex::new(());
        static COUNT: Mutex<u32> = Mutex::new(0);
        let lock = LOCK.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let mut count = COUNT.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        *count += 1;
        // The RTPS ports of domains above 101 are in Linux's range of ephemeral ports.
        let domain_id = 1 + (std::process::id() * 7 + *count) % 101;
        Nodes {
            domain_id: domain_id as u16,
            processes: HashMap::new(),
            variables: Vec::new(),
            directory: tempfile::tempdir().expect("a temporary directory can be created"),
            started: 0,
            _lock: lock,
        }
    }

    /// Returns the path of a file in a temporary directory, which is deleted when this value is
    /// dropped.
    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// Sets an environment variable for all processes that are started from now on.
    pub fn set_variable(&mut self, name: &str, value: &str) {
        self.variables.push((name.to_owned(), value.to_owned()));
    }

    /// Returns a command whose environment selects this domain.
    pub fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command
            .env("ROS_DOMAIN_ID", self.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .envs(self.variables.iter().map(|(name, value)| (name, value)))
            // Keeps the scripts from applying the corrections to RustDDS, which would replace the
            // build under test.
            .envs((!is_corrected()).then_some(("EVAC_UNCORRECTED", "1")))
            .stdin(Stdio::null());
        command
    }

    /// Returns a command that runs a Python peer from `tests/peers`.
    pub fn peer(&self, name: &str) -> Command {
        let python = std::env::var("EVAC_PYTHON")
            .expect("EVAC_PYTHON is not set (run the tests with launch_scripts/test.sh)");
        let mut peer = self.command(python);
        peer.arg(repository().join("tests/peers").join(name));
        peer
    }

    /// Runs a command and returns its exit status, standard output and standard error. Kills the
    /// command and panics after five times [`TIMEOUT`].
    pub fn run(&self, command: &mut Command) -> (ExitStatus, String, String) {
        let open = |name: &str| self.path(&format!("{name}-{}", self.domain_id));
        let (out, err) = (open("stdout"), open("stderr"));
        let create = |path: &Path| File::create(path).expect("the output file can be created");
        let mut child = command
            .stdout(create(&out))
            .stderr(create(&err))
            .spawn()
            .unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let end = Instant::now() + 5 * TIMEOUT;
        let read = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
        let status = loop {
            if let Some(status) = child.try_wait().expect("a child process") {
                break status;
            }
            if Instant::now() > end {
                let _ = child.kill();
                panic!("{command:?} did not exit:\n{}", read(&err));
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        (status, read(&out), read(&err))
    }

    /// Returns the discovery settings with which a participant in this process joins the domain.
    pub fn discovery(&self, security: Security) -> Discovery {
        Discovery { domain_id: self.domain_id, range: Range::Localhost, security }
    }

    /// Creates a node in this process that joins the domain.
    pub fn client(&self) -> Node {
        self.client_with(Security::Off)
    }

    /// Creates a node like [`Nodes::client`], but with the given security settings.
    pub fn client_with(&self, security: Security) -> Node {
        Node::with_discovery(
            "test_client",
            &Arguments::default(),
            evac_msgs::DEFINITIONS,
            self.discovery(security),
        )
        .expect("the node can be created")
    }

    /// Returns the resident memory of a process in MB (10^6 bytes); NaN once it has exited.
    pub fn memory_mb(&mut self, name: &str) -> f64 {
        let status = format!("/proc/{}/status", self.process(name).child.id());
        let status = std::fs::read_to_string(status).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
        kibibytes.map_or(f64::NAN, |kibibytes| kibibytes * 1024.0 / 1e6)
    }

    /// Returns the memory limit of a process in bytes; `None` if it is unlimited.
    pub fn memory_limit(&mut self, name: &str) -> Option<u64> {
        let limits = format!("/proc/{}/limits", self.process(name).child.id());
        let limits = std::fs::read_to_string(limits).ok()?;
        let line = limits.lines().find_map(|line| line.strip_prefix("Max data size"))?;
        line.split_whitespace().next()?.parse().ok()
    }

    /// Returns the number of open file descriptors of a process; `None` once it has exited.
    pub fn handles(&mut self, name: &str) -> Option<usize> {
        let handles = format!("/proc/{}/fd", self.process(name).child.id());
        Some(std::fs::read_dir(handles).ok()?.count())
    }

    /// Waits until a process exits and returns its peak resident memory in MB (10^6 bytes), sampled
    /// every 100 ms.
    pub fn peak_memory_mb(&mut self, name: &str, timeout: Duration) -> f64 {
        let end = Instant::now() + timeout;
        let mut peak = 0f64;
        while self.process(name).child.try_wait().expect("a child process").is_none() {
            assert!(Instant::now() < end, "{name} did not exit:\n{}", self.log(name));
            // `max` ignores the NaN of a process that has just exited.
            peak = peak.max(self.memory_mb(name));
            std::thread::sleep(Duration::from_millis(100));
        }
        peak
    }

    /// Starts `sim_node` with parameters such as `max_steps:=100`.
    pub fn start_simulator(&mut self, parameters: &[&str]) {
        self.start("sim_node", None, parameters);
    }

    /// Starts `agent_node` with a command (`train`, `evaluate` or `drive`) and parameters.
    pub fn start_agent(&mut self, command: &str, parameters: &[&str]) {
        self.start("agent_node", Some(command), parameters);
    }

    /// Starts `agent_node` with a command and a parameter file.
    pub fn start_agent_with_file(&mut self, command: &str, file: &Path) {
        let file = file.to_str().expect("the path is valid Unicode");
        self.start_with("agent_node", &[command, "--ros-args", "--params-file", file]);
    }

    fn start(&mut self, name: &str, command: Option<&str>, parameters: &[&str]) {
        self.start_with(name, &arguments(command, parameters));
    }

    fn start_with(&mut self, name: &str, arguments: &[&str]) {
        self.start_beside(name, name, arguments);
    }

    /// Starts a program with arbitrary arguments and registers the process under `name`.
    pub fn start_beside(&mut self, program: &str, name: &str, arguments: &[&str]) {
        let process = self.command(binary(program));
        self.spawn(process, name, arguments);
    }

    /// Starts `sim_node` with parameters on a [`Host`] and registers the process under `name`.
    pub fn start_simulator_on(&mut self, host: &Host, name: &str, parameters: &[&str]) {
        self.start_on(host, "sim_node", name, &arguments(None, parameters));
    }

    /// Starts `agent_node` with a command and parameters on a [`Host`] and registers the process
    /// under `name`.
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
        let output = File::options().append(true).create(true).open(&log).expect("the log opens");
        process.stdout(output.try_clone().expect("the handle can be cloned")).stderr(output);
        let child = process.spawn().expect("the node starts");
        let previous = self.processes.insert(name.to_owned(), Process { child, log });
        if let Some(mut previous) = previous {
            let _ = previous.child.kill();
            let _ = previous.child.wait();
        }
    }

    /// Kills a process with SIGKILL, which leaves it no time to shut down.
    pub fn kill(&mut self, name: &str) {
        let process = self.process(name);
        process.child.kill().expect("the process is running");
        process.child.wait().expect("a child process");
    }

    /// Returns the ID of a process.
    pub fn process_id(&mut self, name: &str) -> u32 {
        self.process(name).child.id()
    }

    /// Sends a signal, such as `INT`, to a process.
    pub fn signal(&mut self, name: &str, signal: &str) {
        let pid = self.process_id(name).to_string();
        let status = Command::new("kill").args(["-s", signal, &pid]).status();
        assert!(status.expect("kill runs").success(), "cannot send SIG{signal} to {name}");
    }

    /// Waits until a process exits and returns its status. Panics after `timeout`.
    pub fn wait(&mut self, name: &str, timeout: Duration) -> ExitStatus {
        let end = Instant::now() + timeout;
        loop {
            if let Some(status) = self.process(name).child.try_wait().expect("a child process") {
                return status;
            }
            let log = self.log(name);
            assert!(Instant::now() < end, "{name} did not exit within {timeout:?}:\n{log}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Returns the exit status of a process; `None` while it is running.
    pub fn ended(&mut self, name: &str) -> Option<ExitStatus> {
        self.process(name).child.try_wait().expect("a child process")
    }

    /// Waits until a process exits. Panics after `timeout`, or if the process fails.
    pub fn succeed(&mut self, name: &str, timeout: Duration) {
        let status = self.wait(name, timeout);
        let log = self.log(name);
        assert!(status.success(), "{name} failed ({status}):\n{log}");
    }

    /// Waits until the log of a process contains `text`. Panics after [`TIMEOUT`].
    pub fn wait_for_log(&mut self, name: &str, text: &str) {
        let end = Instant::now() + TIMEOUT;
        while !self.log(name).contains(text) {
            let log = self.log(name);
            assert!(Instant::now() < end, "{name} did not log '{text}':\n{log}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until a condition holds. Panics after [`TIMEOUT`] with the log of the process `name`.
    pub fn wait_until(&mut self, name: &str, condition: impl Fn() -> bool) {
        let end = Instant::now() + TIMEOUT;
        while !condition() {
            assert!(Instant::now() < end, "{name}: condition not met:\n{}", self.log(name));
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until the simulator has executed `steps` more steps. Panics if the next one takes
    /// longer than [`TIMEOUT`].
    pub fn wait_for_steps(&mut self, steps: u32) {
        let node = self.client();
        let subscription = node.create_subscription::<EpisodeStatus>("episode", reliable(10));
        let subscription = subscription.expect("the subscription can be created");
        let executed = node.block_on(async {
            let mut executed = 0;
            while executed < steps {
                let next = tokio::time::timeout(TIMEOUT, subscription.async_take()).await;
                match next {
                    Ok(Ok((status, _))) => executed += u32::from(status.step > 0),
                    Ok(Err(error)) => panic!("cannot decode a message on /episode: {error}"),
                    Err(_) => break,
                }
            }
            executed
        });
        assert_eq!(executed, steps, "no step within {TIMEOUT:?}:\n{}", self.log("agent_node"));
    }

    /// Returns what a process has written to standard output and standard error so far.
    pub fn log(&mut self, name: &str) -> String {
        let file = File::open(&self.process(name).log).expect("the log exists from the start");
        let lines = BufReader::new(file).lines();
        lines.map_while(Result::ok).map(|line| line + "\n").collect()
    }

    fn process(&mut self, name: &str) -> &mut Process {
        self.processes.get_mut(name).unwrap_or_else(|| panic!("{name} was not started"))
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
