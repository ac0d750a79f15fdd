//! The values of the field `status` of the responses to [`Reset`](crate::Reset) and
//! [`Step`](crate::Step).
//!
//! Whatever is not [`OK`] has changed nothing, carries an empty image and a message that says what
//! was wrong and why.

/// Done, now or when the same request came first.
pub const OK: u8 = 0;
/// The action is not one of the seven, 0 to 6.
pub const INVALID_ACTION: u8 = 1;
/// This simulator never began an episode with the given number.
pub const UNKNOWN_EPISODE: u8 = 2;
/// The episode belongs to an earlier start of the simulator, which has forgotten it.
pub const SIMULATOR_RESTARTED: u8 = 3;
/// The step is neither the next one of its episode nor the last one again.
pub const OUT_OF_ORDER: u8 = 4;
/// The step was taken already, with another action.
pub const ACTION_DIFFERS: u8 = 5;
/// The episode was terminated or truncated: only a reset goes on from there.
pub const EPISODE_OVER: u8 = 6;
/// No scenario has the given name, or there is no room in it for what the parameters hold fixed.
pub const INVALID_SCENARIO: u8 = 7;
/// A later reset has taken the place of this one, or of this episode; or the episode is driven by
/// the other way (/step or /action).
pub const SUPERSEDED: u8 = 8;

/// The name of a status as it stands in the definitions of the services, for logs and errors;
/// `an unknown status` for a value without one.
pub fn name(status: u8) -> &'static str {
    match status {
        OK => "OK",
        INVALID_ACTION => "INVALID_ACTION",
        UNKNOWN_EPISODE => "UNKNOWN_EPISODE",
        SIMULATOR_RESTARTED => "SIMULATOR_RESTARTED",
        OUT_OF_ORDER => "OUT_OF_ORDER",
        ACTION_DIFFERS => "ACTION_DIFFERS",
        EPISODE_OVER => "EPISODE_OVER",
        INVALID_SCENARIO => "INVALID_SCENARIO",
        SUPERSEDED => "SUPERSEDED",
        _ => "an unknown status",
    }
}
