//! Measures discovery: the time from the start of a publisher or subscriber to the first image.

use std::time::Instant;

use experiments::{Nodes, TIMEOUT};
use ros_interfaces::sensor_msgs::Image;
use ros_runtime::node::{Node, reliable};

use crate::quantile::median;

const ROUNDS: usize = 7;
/// Makes the simulator publish images continuously, without any service call.
const CAMERA: &str = "frame_rate:=100.0";

/// Median time from the start of the later endpoint to the first image received, in seconds.
pub struct StartUpFigures {
    /// The `sim_node` process starts while a subscriber is waiting.
    pub publisher_later_s: f64,
    /// A participant with a subscriber starts while `sim_node` is running.
    pub subscriber_later_s: f64,
}

pub fn measure() -> anyhow::Result<StartUpFigures> {
    let (mut publisher_later, mut subscriber_later) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let mut nodes = Nodes::new();
        let early = nodes.client();
        let images = early.create_subscription::<Image>("camera/image", reliable(1))?;
        let started = Instant::now();
        nodes.start_simulator(&[CAMERA]);
        early.block_on(async { tokio::time::timeout(TIMEOUT, images.async_take()).await })??;
        publisher_later.push(started.elapsed().as_secs_f64());

        let started = Instant::now();
        let late: Node = nodes.client();
        let images = late.create_subscription::<Image>("camera/image", reliable(1))?;
        late.block_on(async { tokio::time::timeout(TIMEOUT, images.async_take()).await })??;
        subscriber_later.push(started.elapsed().as_secs_f64());
    }
    Ok(StartUpFigures {
        publisher_later_s: median(&mut publisher_later),
        subscriber_later_s: median(&mut subscriber_later),
    })
}
