//! What a ROS 2 node needs and ros2-client leaves out.
//!
//! [ros2-client](https://crates.io/crates/ros2-client) brings nodes, topics and services over DDS.
//! A node that is started beside rclcpp and rclpy nodes needs more, and finds it here, layer by
//! layer; each is usable alone:
//!
//! - [`arguments`]: `--ros-args` with remappings, parameter overrides, files and log levels, taken
//!   off the command line before the program parses what is its own.
//! - [`discovery`]: `ROS_DOMAIN_ID`, `ROS_AUTOMATIC_DISCOVERY_RANGE`, `ROS_LOCALHOST_ONLY`: which
//!   domain a participant joins, and on which networks.
//! - [`corrections`]: whether RustDDS is the published crate or one with its faults corrected.
//! - [`security`]: SROS2: with whose keys a participant joins, where the feature of that name is on.
//! - [`rmw`]: `RMW_IMPLEMENTATION`: how the others map services to DDS.
//! - [`names`]: relative and private names, namespaces and remapping.
//! - [`parameters`]: typed declaration with descriptions and ranges, files in YAML, the services
//!   that `ros2 param` talks to.
//! - [`logging`]: the console in ROS's format, and `/rosout`.
//! - [`clock`]: the time on the wall, or that of `/clock`: `use_sim_time`.
//! - [`diagnostics`]: how the parts of a node are, once a second.
//! - [`node`]: a node with its publishers, subscriptions and services; a publisher knows whether
//!   anybody reads, so that nothing is serialised for nobody, and the node describes its types to
//!   whoever asks.
//! - [`service`]: a client that repeats a request until its deadline, because one datagram may be
//!   lost and a server cannot know whether its answer is heard.
//! - [`latency`]: how long a service's answers take.
//! - [`server`]: a server that a client's death does not silence.
//! - [`spin`]: waiting without falling asleep at once, which is what a round trip costs most.
//! - [`shutdown`]: SIGINT and SIGTERM as something that blocking and asynchronous code can wait for.
//! - [`failure`]: a node that fails in one of its threads ends, and none takes all of the memory.

pub mod arguments;
pub mod clock;
pub mod corrections;
pub mod diagnostics;
pub mod discovery;
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
