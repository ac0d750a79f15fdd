//! The values of the `status` field in the responses of the two services, `Reset` and `Step`.
//!
//! ROS definitions cannot share constants, so `Reset.srv` and `Step.srv` both define these values.

use crate::{reset, step};

/// Re-exports constants of `step::Response` and asserts that `reset::Response` has the same values.
macro_rules! shared {
    ($($name:ident),* $(,)?) => {
        $(
            #[doc = concat!("Same as [`step::Response::", stringify!($name), "`].")]
            pub const $name: u8 = step::Response::$name;
            const _: () = assert!(step::Response::$name == reset::Response::$name);
        )*

        /// Returns the name of a status for messages and logs.
        pub fn name(status: u8) -> &'static str {
            match status {
                $($name => stringify!($name),)*
                _ => "unknown status",
            }
        }
    };
}

shared!(
    OK,
    INVALID_ACTION,
    UNKNOWN_EPISODE,
    SIMULATOR_RESTARTED,
    OUT_OF_ORDER,
    ACTION_DIFFERS,
    EPISODE_OVER,
    INVALID_SCENARIO,
    SUPERSEDED,
);
