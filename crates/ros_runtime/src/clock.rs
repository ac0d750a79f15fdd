//! ROS time: that of the wall or, with `use_sim_time`, what `/clock` says.
//!
//! The parameter may change while the node runs. `/clock` is subscribed to only as long as it is
//! wanted: a simulator publishes it with every step.

use std::{
    future::ready,
    sync::Arc,
    time::{SystemTime, UNIX_EPOCH},
};

use futures::StreamExt;
use log::warn;
use parking_lot::{Mutex, MutexGuard};
use ros_interfaces::{builtin_interfaces::Time, rosgraph_msgs};
use ros2_client::Subscription;
use tokio::{select, sync::watch};

use crate::parameters::{Descriptor, ParameterError, ParameterValue, Parameters};

/// The parameter that says which time it is; every node has it.
pub const USE_SIM_TIME: &str = "use_sim_time";

/// A node's clock; a cheap handle that can be shared.
#[derive(Clone, Debug)]
pub struct Clock {
    is_simulated: watch::Sender<bool>,
    /// What `/clock` said last. Nothing yet is 0, as in rcl.
    simulated: Arc<Mutex<Time>>,
}

impl Clock {
    /// A clock that goes by the parameter, which is declared here.
    pub(crate) fn declare(parameters: &Parameters) -> Result<Clock, ParameterError> {
        let descriptor = Descriptor::dynamic("take the time from /clock, not from the wall");
        let is_simulated = parameters.declare(USE_SIM_TIME, false, descriptor)?;
        Ok(Clock { is_simulated: watch::Sender::new(is_simulated), simulated: Arc::default() })
    }

    /// The time now.
    pub fn now(&self) -> Time {
        match *self.is_simulated.borrow() {
            true => *self.simulated(),
            false => wall_time(),
        }
    }

    /// The parameter has changed.
    pub(crate) fn obey(&self, use_sim_time: &ParameterValue) {
        if let ParameterValue::Bool(is_simulated) = *use_sim_time {
            self.is_simulated.send_replace(is_simulated);
        }
    }

    /// Follows `/clock` for ever, while it is wanted.
    pub(crate) async fn follow(
        self,
        subscribe: impl Fn() -> Result<Subscription<rosgraph_msgs::Clock>, String>,
    ) {
        let mut is_simulated = self.is_simulated.subscribe();
        // The sender lives as long as this clock.
        while is_simulated.wait_for(|wanted| *wanted).await.is_ok() {
            *self.simulated() = Time::default();
            let subscription = match subscribe() {
                Ok(subscription) => subscription,
                Err(reason) => return warn!("/clock cannot be heard: {reason}"),
            };
            let hear = subscription.async_stream().for_each(|message| {
                match message {
                    Ok((message, _)) => *self.simulated() = message.clock,
                    Err(error) => warn!("a message on /clock cannot be read: {error}"),
                }
                ready(())
            });
            select! {
                () = hear => {}
                unwanted = is_simulated.wait_for(|wanted| !*wanted) => drop(unwanted),
            }
        }
    }

    fn simulated(&self) -> MutexGuard<'_, Time> {
        self.simulated.lock()
    }
}

/// The time on the wall, as ROS writes it.
fn wall_time() -> Time {
    let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    // builtin_interfaces/Time ends in 2038.
    let sec = i32::try_from(since_epoch.as_secs()).unwrap_or(i32::MAX);
    Time { sec, nanosec: since_epoch.subsec_nanos() }
}
