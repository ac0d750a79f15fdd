//! ROS 2 node infrastructure on top of ros2-client.
//!
//! [ros2-client](https://crates.io/crates/ros2-client) provides nodes, topics and services over
//! DDS. This crate adds what a node needs to work alongside rclcpp and rclpy nodes. Each module can
//! be used on its own:
//!
//! - [`arguments`]: `--ros-args` with remappings, parameter overrides, parameter files and log
//!   levels, separated from the program's own arguments.
//! - [`discovery`]: the DDS domain and networks of a participant, from `ROS_DOMAIN_ID`,
//!   `ROS_AUTOMATIC_DISCOVERY_RANGE` and `ROS_LOCALHOST_ONLY`.
//! - [`corrections`]: whether RustDDS is the published crate or a patched copy.
//! - [`security`]: SROS2, with the feature `security`.
//! - [`rmw`]: the mapping from services to DDS, selected by `RMW_IMPLEMENTATION`.
//! - [`names`]: relative, private and absolute names, namespaces and remapping.
//! - [`parameters`]: typed declarations with descriptions and ranges, YAML files, and the services
//!   that `ros2 param` calls.
//! - [`logging`]: console output in ROS's format, and `/rosout`.
//! - [`clock`]: system time, or simulated time from `/clock` with `use_sim_time`.
//! - [`diagnostics`]: the status of a node's components on `/diagnostics`, once a second.
//! - [`node`]: a node with publishers, subscriptions, servers and clients. Publishers skip
//!   serialization if they have no subscribers, and `~/get_type_description` describes the node's
//!   types.
//! - [`qos`]: quality-of-service profiles for topics.
//! - [`service`]: a service client that retries a request until its timeout expires.
//! - [`latency`]: the response times of a service.
//! - [`server`]: a service server that keeps responding after a client has been killed.
//! - [`spin`]: an executor whose thread stays awake briefly before it sleeps, which shortens round
//!   trips.
//! - [`shutdown`]: SIGINT, SIGTERM and SIGHUP as a future.
//! - [`failure`]: exits the process on a panic, and limits its memory.
//!
//! # Examples
//!
//! A node that publishes a heartbeat once a second. `examples/minimal_node.rs` adds a parameter and
//! a service.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! use ros_interfaces::std_msgs::Header;
//! use ros_runtime::{Arguments, Node, node::reliable};
//! use tokio::time::interval;
//!
//! let mut node = Node::new("heartbeat", &Arguments::from_environment()?, &[])?;
//! let heartbeat = node.create_publisher::<Header>("heartbeat", reliable(10))?;
//! node.start_services()?;
//! node.block_on(async {
//!     let mut ticks = interval(Duration::from_secs(1));
//!     while node.shutdown().unless_requested(ticks.tick()).await.is_some() {
//!         heartbeat.publish_with(|| Header { stamp: node.clock().now(), ..Header::default() });
//!     }
//! });
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod arguments;
pub mod clock;
pub mod corrections;
pub mod diagnostics;
pub mod discovery;
mod escape;
pub mod failure;
mod graph;
pub mod latency;
pub mod logging;
pub mod names;
pub mod node;
mod node_error;
pub mod parameters;
mod publisher;
pub mod qos;
mod report;
pub mod rmw;
pub mod security;
pub mod server;
pub mod service;
mod shared_node;
pub mod shutdown;
pub mod spin;
mod types;

pub use arguments::Arguments;
pub use clock::Clock;
pub use node::Node;
pub use publisher::Publisher;
pub use shutdown::Shutdown;
