//! Logging: the `log` crate's records on the console in ROS's format, and on `/rosout`.
//!
//! What this project's own crates say is the node's and goes to both. Libraries speak on the
//! console only, and by default only when something is wrong: their warnings are about the wire
//! and come by the thousand. `--log-level rustdds:=debug` opens one of them.

mod format;

use std::{
    io::Write,
    sync::{Arc, Mutex, OnceLock},
    time::SystemTime,
};

use log::{Level, LevelFilter, Log, Metadata, Record};
use ros2_client::{NodeLoggingHandle, RosoutRaw, builtin_interfaces::Time, log::LogLevel};

use self::format::Format;
pub use self::format::InvalidColorization;
use crate::arguments::Arguments;

static LOGGER: OnceLock<Logger> = OnceLock::new();

struct Logger {
    /// The ROS logger's name: the node's.
    name: String,
    level: LevelFilter,
    /// What libraries may say unless somebody asks for more.
    libraries: LevelFilter,
    /// Levels by the beginning of a record's target.
    levels: Vec<(String, LevelFilter)>,
    format: Format,
    to_console: bool,
    to_rosout: bool,
    outputs: Mutex<Outputs>,
}

#[derive(Default)]
struct Outputs {
    rosout: Option<Arc<NodeLoggingHandle>>,
    console: Option<Console>,
    libraries_muted: bool,
}

/// Writes a line where a progress bar stands: the bar steps aside.
type Console = Box<dyn Fn(&str) + Send>;

/// The crates whose records are the node's own.
const OWN: [&str; 3] = ["sim_node", "agent_node", "ros_runtime"];

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

/// Starts logging under a node's name, with what libraries may say unless somebody asks for more. The
/// first call of a process counts.
pub fn start(
    name: &str,
    arguments: &Arguments,
    libraries: LevelFilter,
) -> Result<(), InvalidColorization> {
    let format = Format::from_environment()?;
    let level = arguments.log_level.unwrap_or(LevelFilter::Info);
    let logger = LOGGER.get_or_init(|| Logger {
        name: name.to_owned(),
        level,
        libraries,
        levels: arguments.logger_levels.clone(),
        format,
        to_console: arguments.logs_to_console,
        to_rosout: arguments.logs_to_rosout,
        outputs: Mutex::default(),
    });
    // Fails where somebody set a logger before, as a test's harness may: then that one stays.
    if log::set_logger(logger).is_ok() {
        let loudest = arguments.logger_levels.iter().map(|(_, level)| *level).max();
        log::set_max_level(loudest.unwrap_or(level).max(level));
    }
    Ok(())
}

/// From now on the node's records go to `/rosout`, too.
pub(crate) fn publish_to(rosout: NodeLoggingHandle) {
    with_outputs(|outputs| {
        outputs.rosout = Some(Arc::new(rosout));
        outputs.libraries_muted = false;
    });
}

/// No record goes to `/rosout` any more: its writer keeps the DDS participant alive.
///
/// Libraries are not heard any more, either: RustDDS calls it an error that a socket on loopback
/// leaves a multicast group which it never joined.
pub(crate) fn stop_publishing() {
    with_outputs(|outputs| {
        outputs.rosout = None;
        outputs.libraries_muted = true;
    });
}

/// From now on the console is written through this function, as a progress bar needs it.
pub fn write_console_through(console: impl Fn(&str) + Send + 'static) {
    with_outputs(|outputs| outputs.console = Some(Box::new(console)));
}

fn with_outputs(change: impl FnOnce(&mut Outputs)) {
    if let Some(logger) = LOGGER.get() {
        change(&mut logger.lock());
    }
}

impl Logger {
    fn lock(&self) -> std::sync::MutexGuard<'_, Outputs> {
        self.outputs.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn level_of(&self, target: &str) -> LevelFilter {
        let root = target.split("::").next().unwrap_or(target);
        let own = OWN.contains(&root);
        let named = self.levels.iter().rev().find(|(logger, _)| {
            target.starts_with(logger.as_str()) || (own && *logger == self.name)
        });
        match named {
            Some((_, level)) => *level,
            None if own => self.level,
            None => self.libraries.min(self.level),
        }
    }
}

impl Log for Logger {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.level() <= self.level_of(metadata.target())
    }

    fn log(&self, record: &Record) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let own = OWN.contains(&record.target().split("::").next().unwrap_or_default());
        let name = if own { self.name.as_str() } else { record.target() };
        let message = record.args().to_string();
        let outputs = self.lock();
        if outputs.libraries_muted && !own {
            return;
        }
        if self.to_console {
            let line = self.format.line(record, SystemTime::now(), name, &message);
            match &outputs.console {
                Some(console) => console(&line),
                // A closed console is no reason to stop.
                None => drop(writeln!(std::io::stderr(), "{line}")),
            }
        }
        // RustDDS may have something to log while it publishes: not under this lock.
        let rosout = outputs.rosout.clone().filter(|_| own && self.to_rosout);
        drop(outputs);
        if let Some(rosout) = rosout {
            rosout.rosout_raw(
                Time::now(),
                rosout_level(record.level()),
                name,
                &message,
                record.file().unwrap_or_default(),
                record.module_path().unwrap_or_default(),
                record.line().unwrap_or_default(),
            );
        }
    }

    fn flush(&self) {}
}

fn rosout_level(level: Level) -> LogLevel {
    match level {
        Level::Error => LogLevel::Error,
        Level::Warn => LogLevel::Warn,
        Level::Info => LogLevel::Info,
        Level::Debug | Level::Trace => LogLevel::Debug,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn logger(level: LevelFilter, levels: &[(&str, LevelFilter)]) -> Logger {
        Logger {
            name: "sim_node".to_owned(),
            level,
            libraries: LevelFilter::Error,
            levels: levels.iter().map(|(name, level)| (name.to_string(), *level)).collect(),
            format: Format::new("", false),
            to_console: true,
            to_rosout: true,
            outputs: Mutex::default(),
        }
    }

    #[test]
    fn libraries_are_quiet_unless_asked() {
        let quiet = logger(LevelFilter::Info, &[]);
        assert_eq!(quiet.level_of("sim_node::ros"), LevelFilter::Info);
        assert_eq!(quiet.level_of("rustdds::rtps"), LevelFilter::Error);
        let open = logger(LevelFilter::Warn, &[("rustdds", LevelFilter::Debug)]);
        assert_eq!(open.level_of("rustdds::rtps"), LevelFilter::Debug);
        assert_eq!(open.level_of("ros_runtime::node"), LevelFilter::Warn);
        let by_name = logger(LevelFilter::Info, &[("sim_node", LevelFilter::Error)]);
        assert_eq!(by_name.level_of("ros_runtime::node"), LevelFilter::Error);
    }
}
