//! ROS time: the system time or, with the parameter `use_sim_time`, the time on `/clock`.
//!
//! The parameter can change while the node runs. The node subscribes to `/clock` only while
//! `use_sim_time` is true, because a simulator may publish on it thousands of times a second.

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

/// The parameter that selects the time source; every node has it.
pub const USE_SIM_TIME: &str = "use_sim_time";

/// A node's clock. Clones share the same time.
///
/// # Examples
///
/// ```no_run
/// use ros_interfaces::std_msgs::Header;
/// use ros_runtime::{Arguments, Node};
///
/// let node = Node::new("camera", &Arguments::from_environment()?, &[])?;
/// let header = Header { stamp: node.clock().now(), frame_id: "camera_link".to_owned() };
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Clock {
    is_simulated: watch::Sender<bool>,
    /// The latest time on `/clock`; 0 before the first message, as in rcl.
    simulated: Arc<Mutex<Time>>,
}

impl Clock {
    /// Declares the parameter `use_sim_time` and returns a clock that uses it.
    pub(crate) fn declare(parameters: &Parameters) -> Result<Clock, ParameterError> {
        let descriptor = Descriptor::dynamic("use the time on /clock instead of the system time");
        let is_simulated = parameters.declare(USE_SIM_TIME, false, descriptor)?;
        Ok(Clock { is_simulated: watch::Sender::new(is_simulated), simulated: Arc::default() })
    }

    /// Returns the current time; with `use_sim_time`, 0 until the first message on `/clock`.
    pub fn now(&self) -> Time {
        match *self.is_simulated.borrow() {
            true => *self.simulated(),
            false => system_time(),
        }
    }

    /// Applies a change to the parameter `use_sim_time`.
    pub(crate) fn set_source(&self, use_sim_time: &ParameterValue) {
        if let ParameterValue::Bool(is_simulated) = *use_sim_time {
            self.is_simulated.send_replace(is_simulated);
        }
    }

    /// Follows `/clock` whenever `use_sim_time` is true, until the task is dropped.
    pub(crate) async fn follow(
        self,
        subscribe: impl Fn() -> Result<Subscription<rosgraph_msgs::Clock>, String>,
    ) {
        let mut is_simulated = self.is_simulated.subscribe();
        // Waiting does not fail, because the sender lives as long as this clock.
        while is_simulated.wait_for(|is_simulated| *is_simulated).await.is_ok() {
            *self.simulated() = Time::default();
            let subscription = match subscribe() {
                Ok(subscription) => subscription,
                Err(reason) => return warn!("could not subscribe to /clock: {reason}"),
            };
            let receive = subscription.async_stream().for_each(|message| {
                match message {
                    Ok((message, _)) => *self.simulated() = message.clock,
                    Err(error) => warn!("/clock: could not read a message: {error}"),
                }
                ready(())
            });
            select! {
                () = receive => {}
                changed = is_simulated.wait_for(|is_simulated| !*is_simulated) => drop(changed),
            }
        }
    }

    fn simulated(&self) -> MutexGuard<'_, Time> {
        self.simulated.lock()
    }
}

/// Returns the system time since the Unix epoch.
fn system_time() -> Time {
    let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    // The seconds of builtin_interfaces/Time overflow in 2038.
    let sec = i32::try_from(since_epoch.as_secs()).unwrap_or(i32::MAX);
    Time { sec, nanosec: since_epoch.subsec_nanos() }
}
