//! The values of the field `status` of both services, which a definition of ROS cannot share.

use crate::{reset, step};

macro_rules! shared {
    ($($name:ident),* $(,)?) => {
        $(
            #[doc = concat!("[`step::Response::", stringify!($name), "`], and that of a reset.")]
            pub const $name: u8 = step::Response::$name;
            const _: () = assert!(step::Response::$name == reset::Response::$name);
        )*

        /// The name of a status, for people.
        pub fn name(status: u8) -> &'static str {
            match status {
                $($name => stringify!($name),)*
                _ => "an unknown status",
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
