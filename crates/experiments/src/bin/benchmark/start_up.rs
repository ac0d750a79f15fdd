//! How soon a node that starts is heard, and how soon it hears.

use std::time::Instant;

use experiments::{Nodes, PATIENCE};
use ros_interfaces::sensor_msgs::Image;
use ros_runtime::node::{Node, reliable};

use crate::median;

const ROUNDS: usize = 7;
/// A camera that shows something without being asked.
const CAMERA: &str = "frame_rate:=100.0";

/// Seconds from the start of the later one to the first image that a subscriber has.
pub struct StartUpFigures {
    /// The subscriber was there, and `sim_node` starts, as a process.
    pub publisher_later_s: f64,
    /// `sim_node` was there, and a participant with a subscriber starts.
    pub subscriber_later_s: f64,
}

pub fn measure() -> anyhow::Result<StartUpFigures> {
    let (mut publisher_later, mut subscriber_later) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let mut nodes = Nodes::new();
        let early = nodes.client();
        let listening = early.create_subscription::<Image>("camera/image", reliable(1))?;
        let started = Instant::now();
        nodes.start_simulator(&[CAMERA]);
        early
            .block_on(async { tokio::time::timeout(PATIENCE, listening.async_take()).await })??;
        publisher_later.push(started.elapsed().as_secs_f64());

        let started = Instant::now();
        let late: Node = nodes.client();
        let listening = late.create_subscription::<Image>("camera/image", reliable(1))?;
        late.block_on(async { tokio::time::timeout(PATIENCE, listening.async_take()).await })??;
        subscriber_later.push(started.elapsed().as_secs_f64());
    }
    Ok(StartUpFigures {
        publisher_later_s: median(&mut publisher_later),
        subscriber_later_s: median(&mut subscriber_later),
    })
}
