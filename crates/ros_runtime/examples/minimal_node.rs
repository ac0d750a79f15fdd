//! A minimal node with a parameter, a publisher and a service.
//!
//! It publishes `std_msgs/Header` on `heartbeat` every `period` seconds. The `toggle` service
//! (`std_srvs/Trigger`) stops and restarts publishing.
//!
//! Run it from the root of the repository:
//!
//! ```sh
//! cargo run --package ros_runtime --example minimal_node -- --ros-args -p period:=0.5
//! ```
//!
//! In another terminal, with ROS 2 sourced:
//!
//! ```sh
//! ros2 topic echo /heartbeat
//! ros2 param describe /minimal_node period
//! ros2 service call /toggle std_srvs/srv/Trigger
//! ```
//!
//! `ros_interfaces` does not include `std_srvs`, so the service is defined at the end of this file.
//! For your own packages, generate such types in a build script with the crate `rosidl`.

use std::{error::Error, time::Duration};

use log::info;
use ros_interfaces::{Message, RosService, std_msgs::Header};
use ros_runtime::{Arguments, Node, node::reliable, parameters::Descriptor};
use serde::{Deserialize, Serialize};
use tokio::{select, time::interval};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::from_environment()?;
    let mut node = Node::new("minimal_node", &arguments, &[TRIGGER])?;
    let period = Descriptor::read_only("heartbeat period, in seconds").range(0.01..=60.0);
    let period = node.parameters().declare("period", 1.0, period)?;
    node.parameters().reject_undeclared()?;
    let heartbeat = node.create_publisher::<Header>("heartbeat", reliable(10))?;
    let toggle = node.create_server::<Trigger>("toggle")?;
    node.start_services()?;
    info!("publishing a heartbeat every {period} s");

    let (clock, shutdown) = (node.clock(), node.shutdown());
    node.block_on(async {
        let mut ticks = interval(Duration::from_secs_f64(period));
        let mut is_active = true;
        loop {
            select! {
                _ = ticks.tick() => if is_active {
                    heartbeat.publish_with(|| Header { stamp: clock.now(), ..Header::default() });
                },
                (id, _) = toggle.next_request() => {
                    is_active = !is_active;
                    let message = if is_active { "active" } else { "stopped" }.to_owned();
                    toggle.answer(id, Response { success: true, message }).await;
                }
                () = shutdown.requested() => break,
            }
        }
    });
    Ok(())
}

/// The full name and the text of the definition; the node needs them to describe the type.
const TRIGGER: (&str, &str) = ("std_srvs/srv/Trigger", "---\nbool success\nstring message\n");

struct Trigger;

impl RosService for Trigger {
    const PACKAGE: &str = "std_srvs";
    const NAME: &str = "Trigger";
    type Request = Request;
    type Response = Response;
}

/// An empty request: IDL has no empty structs, so ROS adds a member.
#[derive(Clone, Serialize, Deserialize)]
struct Request {
    structure_needs_at_least_one_member: u8,
}

#[derive(Clone, Serialize, Deserialize)]
struct Response {
    success: bool,
    message: String,
}

impl Message for Request {}
impl Message for Response {}
