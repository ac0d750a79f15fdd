//! A node: its name, its parameters, and what it publishes, hears, serves and asks.

use std::{collections::BTreeSet, future::Future, sync::Arc};

pub use crate::{
    node_error::NodeError,
    publisher::{LatchedPublisher, Publisher},
    qos::{best_effort, latched, reliable},
};
use log::warn;
use parking_lot::{Mutex, MutexGuard};
use ros_interfaces::{
    Interfaces, RosMessage, RosService, rosgraph_msgs,
    type_description_interfaces::GetTypeDescription,
};
pub use ros2_client::Subscription;
use ros2_client::{Context, Name, NodeName, NodeOptions, qos::QosProfile};
use tokio::runtime::Runtime;

use crate::{
    arguments::Arguments,
    clock::{Clock, USE_SIM_TIME},
    corrections,
    diagnostics::{Diagnostics, Level, Report},
    discovery::{self, Discovery},
    graph::Graph,
    latency::Latencies,
    logging,
    names::Naming,
    node_error::endpoint,
    parameters::{ParameterServices, Parameters},
    rmw::Rmw,
    server::ServiceServer,
    service::{ServiceClient, create_client},
    shared_node::SharedNode,
    shutdown::Shutdown,
    spin,
    types::Types,
};

/// A ROS 2 node.
pub struct Node {
    // The order is that of dropping: tasks end before the endpoints that they use.
    runtime: Runtime,
    node: SharedNode,
    naming: Naming,
    parameters: Parameters,
    clock: Clock,
    diagnostics: Diagnostics,
    graph: Graph,
    types: Types,
    shutdown: Shutdown,
}

impl Node {
    /// Starts a node: logging, signals, its place in the DDS domain.
    ///
    /// `default_name` is the node's name unless `-r __node:=` gives it another. `definitions` are those
    /// of its own messages and services, besides the standard ones: full names and texts, as the
    /// constant `DEFINITIONS` of a package that the crate `rosidl` has written. By them the node tells
    /// others what its types look like; one without a definition is used all the same.
    ///
    /// # Errors
    ///
    /// Arguments, parameter files or environment are wrong, or DDS does not start.
    pub fn new(
        default_name: &str,
        arguments: &Arguments,
        definitions: &[(&str, &str)],
    ) -> Result<Node, NodeError> {
        let discovery = Discovery::from_environment(&arguments.enclave)?;
        Node::with_discovery(default_name, arguments, definitions, discovery)
    }

    /// As [`Node::new`], in a domain of the caller's choice instead of the environment's.
    ///
    /// # Errors
    ///
    /// As [`Node::new`].
    pub fn with_discovery(
        default_name: &str,
        arguments: &Arguments,
        definitions: &[(&str, &str)],
        discovery: Discovery,
    ) -> Result<Node, NodeError> {
        let rmw = Rmw::from_environment()?;
        let naming = Naming::new(default_name, &arguments.remaps)?;
        // rcl names a node's logger by its dotted full name.
        let logger = naming.fully_qualified().trim_start_matches('/').replace('/', ".");
        logging::start(&logger, arguments, discovery.security.library_level())?;
        discovery::warn_of_static_peers();
        if !corrections::is_corrected() {
            warn!("{}: build again after launch_scripts/setup.sh", corrections::RUSTDDS);
        }
        let parameters = Parameters::new(&naming, arguments)?;
        let clock = Clock::declare(&parameters)?;
        let interfaces = Arc::new(Interfaces::with(definitions)?);
        let types = Types::declare(&parameters, interfaces.clone())?;
        // What ros2-client's node publishes by itself.
        types.add("rcl_interfaces/msg/Log");
        types.add("rcl_interfaces/msg/ParameterEvent");
        let participant = discovery.participant(interfaces)?;
        discovery.security.report();
        // One thread for signals, timers, the graph and the parameter services.
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("ros_runtime")
            .enable_all()
            .build()?;
        let shutdown = Shutdown::default();
        shutdown.listen_to_signals(runtime.handle())?;
        let graph = Graph::default();
        runtime.spawn(graph.clone().follow(participant.clone()));

        let what = format!("the node {}", naming.fully_qualified());
        let context = Context::from_domain_participant(participant).map_err(endpoint(&what))?;
        let name = NodeName::new(&naming.namespace, &naming.node).map_err(endpoint(&what))?;
        // The parameter services of ros2-client live in its Spinner; ours are below.
        let options = NodeOptions::new()
            .enable_rosout(true)
            .start_parameter_services(false)
            .allow_undeclared_parameters(true);
        let node = context.new_node(name, options).map_err(endpoint(&what))?;
        logging::publish_to(node.logging_handle());
        let node = SharedNode::new(node, rmw.service_mapping());
        let diagnostics = Diagnostics::default();
        diagnostics.add("DDS", dds_report);
        Ok(Node { runtime, node, naming, parameters, clock, diagnostics, graph, types, shutdown })
    }

    /// The parameters of a node that is not started: those that every node has are declared. For
    /// programs that tell of a node's parameters, or check its arguments, without a DDS domain.
    ///
    /// # Errors
    ///
    /// A name, a parameter file or a value is wrong.
    pub fn parameters_alone(
        default_name: &str,
        arguments: &Arguments,
    ) -> Result<Parameters, NodeError> {
        let naming = Naming::new(default_name, &arguments.remaps)?;
        let parameters = Parameters::new(&naming, arguments)?;
        Clock::declare(&parameters)?;
        Types::declare(&parameters, Arc::default())?;
        Ok(parameters)
    }

    /// The node's name and remappings.
    pub fn naming(&self) -> &Naming {
        &self.naming
    }

    /// The node's parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The node's clock. It goes by `/clock` only once [`Node::start_services`] was called.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The parts of the node that report on `/diagnostics`.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// The request that the node end.
    pub fn shutdown(&self) -> &Shutdown {
        &self.shutdown
    }

    /// Runs a future on this thread; timers and signals go on beside it.
    ///
    /// While the future waits, the thread stays awake for a moment: see [`spin`].
    pub fn block_on<T>(&self, work: impl Future<Output = T>) -> T {
        let _context = self.runtime.enter();
        spin::block_on(spin::WINDOW, work)
    }

    /// A publisher on a topic.
    pub fn create_publisher<M: RosMessage>(
        &mut self,
        topic: &str,
        qos: QosProfile,
    ) -> Result<Publisher<M>, NodeError> {
        let name = self.naming.resolve(topic)?;
        let topic = self.topic::<M>(&name, &qos)?;
        Publisher::new(&self.node, &self.graph, name, &topic)
    }

    /// A publisher of something that changes and whose latest state every reader gets, however late
    /// it comes.
    pub fn create_latched_publisher<M: RosMessage>(
        &mut self,
        topic: &str,
    ) -> Result<LatchedPublisher<M>, NodeError> {
        let name = self.naming.resolve(topic)?;
        let topic = self.topic::<M>(&name, &latched(1))?;
        LatchedPublisher::new(&self.node, &self.graph, name, topic)
    }

    /// A subscription to a topic.
    pub fn create_subscription<M: RosMessage>(
        &self,
        topic: &str,
        qos: QosProfile,
    ) -> Result<Subscription<M>, NodeError> {
        let name = self.naming.resolve(topic)?;
        let topic = self.topic::<M>(&name, &qos)?;
        self.node().create_subscription(&topic, None).map_err(endpoint(&name))
    }

    /// A server of a service.
    pub fn create_server<S: RosService>(
        &mut self,
        service: &str,
    ) -> Result<ServiceServer<S>, NodeError> {
        let name = self.naming.resolve(service)?;
        self.types.add(&S::full_name());
        ServiceServer::new(name.clone(), self.node.clone()).map_err(endpoint(&name))
    }

    /// A client of a service.
    pub fn create_client<S: RosService>(
        &mut self,
        service: &str,
    ) -> Result<ServiceClient<S>, NodeError> {
        let name = self.naming.resolve(service)?;
        self.types.add(&S::full_name());
        let client = create_client::<S>(&self.node, &name).map_err(endpoint(&name))?;
        // As rmw names it.
        let request_topic = format!("rq{name}Request");
        let servers = self.graph.readers(&request_topic);
        Ok(ServiceClient {
            name,
            request_topic,
            client: Mutex::new(Arc::new(client)),
            node: self.node.clone(),
            servers,
            latencies: Latencies::default(),
            shutdown: self.shutdown.clone(),
        })
    }

    /// Begins to do what every ROS node does besides its work: to answer `ros2 param`, to describe
    /// its types, to publish `/parameter_events` and `/diagnostics`, and to go by `/clock` if it
    /// should. Call it when every parameter is declared.
    pub fn start_services(&mut self) -> Result<(), NodeError> {
        let services = ParameterServices {
            get: self.create_server("~/get_parameters")?,
            get_types: self.create_server("~/get_parameter_types")?,
            list: self.create_server("~/list_parameters")?,
            describe: self.create_server("~/describe_parameters")?,
            set: self.create_server("~/set_parameters")?,
            set_atomically: self.create_server("~/set_parameters_atomically")?,
        };
        self.runtime.spawn(services.serve(self.parameters.clone()));
        if self.types.are_served() {
            let server = self.create_server::<GetTypeDescription>("~/get_type_description")?;
            self.runtime.spawn(self.types.clone().serve(server));
        }
        self.publish_parameter_events();
        let publisher = self.create_publisher("/diagnostics", reliable(10))?;
        let diagnostics = self.diagnostics.clone();
        let name = self.naming.fully_qualified().trim_start_matches('/').to_owned();
        self.runtime.spawn(diagnostics.serve(name, self.clock.clone(), publisher));
        self.follow_clock()
    }

    /// Reports readiness to the supervisor, if it sets `NOTIFY_SOCKET` (sd_notify(3)): systemd does for a
    /// service of `Type=notify`.
    pub fn tell_ready(&self) {
        if let Err(error) = sd_notify::notify(&[sd_notify::NotifyState::Ready]) {
            warn!("NOTIFY_SOCKET: cannot report readiness to the supervisor: {error}");
        }
    }

    /// ros2-client's node has a store of parameters of its own, which is nothing but the way to its
    /// publisher of `/parameter_events`.
    fn publish_parameter_events(&self) {
        let (mut changes, node) = (self.parameters.listen(), self.node.clone());
        let clock = self.clock.clone();
        let readers = self.graph.readers("rt/parameter_events");
        let mut declared = BTreeSet::new();
        self.runtime.spawn(async move {
            while let Some((name, value)) = changes.recv().await {
                // From then on ros2-client would take its time from a Spinner, which nobody runs.
                if name == USE_SIM_TIME {
                    clock.obey(&value);
                    continue;
                }
                // Without a reader RustDDS keeps every event, up to 8,192 of them.
                if !declared.insert(name.clone()) && *readers.borrow() == 0 {
                    continue;
                }
                if let Err(reason) = node.lock().set_parameter(&name, value.into()) {
                    warn!("/parameter_events: the change of {name} is not told: {reason}");
                }
            }
        });
    }

    fn follow_clock(&self) -> Result<(), NodeError> {
        let name = self.naming.resolve("/clock")?;
        // As rclcpp hears it.
        let topic = self.topic::<rosgraph_msgs::Clock>(&name, &best_effort(1))?;
        let node = self.node.clone();
        let subscribe =
            move || node.lock().create_subscription(&topic, None).map_err(|e| e.to_string());
        self.runtime.spawn(self.clock.clone().follow(subscribe));
        Ok(())
    }

    fn node(&self) -> MutexGuard<'_, ros2_client::Node> {
        self.node.lock()
    }

    fn topic<M: RosMessage>(
        &self,
        name: &str,
        qos: &QosProfile,
    ) -> Result<rustdds::Topic, NodeError> {
        let dds_name = Name::parse(name).map_err(endpoint(name))?;
        self.types.add(&M::full_name());
        self.node().create_topic(&dds_name, M::type_name(), qos).map_err(endpoint(name))
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        logging::stop_publishing();
    }
}

/// The build of RustDDS, which decides what the node withstands.
fn dds_report() -> Report {
    let level = if corrections::is_corrected() { Level::Ok } else { Level::Warn };
    let values = vec![("corrections", corrections::corrections().count().to_string())];
    Report { level, message: corrections::RUSTDDS.to_owned(), values }
}
