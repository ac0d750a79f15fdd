//! Levels of logging, by their names.

use log::LevelFilter;

/// A ROS level's name, in any case; `fatal` is no level of the `log` crate and means `error`.
pub(crate) fn parse_level(name: &str) -> Option<LevelFilter> {
    Some(match name.to_ascii_lowercase().as_str() {
        "debug" => LevelFilter::Debug,
        "info" => LevelFilter::Info,
        "warn" => LevelFilter::Warn,
        "error" | "fatal" => LevelFilter::Error,
        _ => return None,
    })
}
