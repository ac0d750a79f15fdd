//! Log level names.

use log::LevelFilter;

/// Returns the level with a ROS name, in upper or lower case, or `None` if the name is unknown.
/// `fatal` maps to `error`, because the `log` crate has no such level.
pub(crate) fn parse_level(name: &str) -> Option<LevelFilter> {
    Some(match name.to_ascii_lowercase().as_str() {
        "debug" => LevelFilter::Debug,
        "info" => LevelFilter::Info,
        "warn" => LevelFilter::Warn,
        "error" | "fatal" => LevelFilter::Error,
        _ => return None,
    })
}
