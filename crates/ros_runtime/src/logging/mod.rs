//! Logging: writes the records of the `log` crate to the console in ROS's format and to `/rosout`.
//!
//! Records from the node go to both outputs. Records from the DDS libraries go only to the console
//! and, by default, only if they are errors, because these libraries can log thousands of warnings
//! about network packets. `--log-level rustdds:=debug` sets the level of one library.
//!
//! A peer may trigger thousands of warnings a second, so each source line logs at most 20 warnings
//! and errors a second. Messages are truncated after 2,000 bytes.
//!
//! # Examples
//!
//! [`Node::new`](crate::Node::new) starts logging. A program without a node starts it itself:
//!
//! ```no_run
//! use log::{LevelFilter, info};
//! use ros_runtime::{Arguments, logging};
//!
//! logging::start("converter", &Arguments::from_environment()?, LevelFilter::Error)?;
//! info!("ready"); // [INFO] [1700000000.000000042] [converter]: ready
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod format;
pub(crate) mod level;

use std::{
    collections::HashMap,
    io::Write,
    sync::{Arc, OnceLock},
    time::{Duration, Instant, SystemTime},
};

use log::{Level, LevelFilter, Log, Metadata, Record};
use parking_lot::{Mutex, MutexGuard};
use ros2_client::{NodeLoggingHandle, RosoutRaw, builtin_interfaces::Time, log::LogLevel};

use self::format::Format;
pub use self::format::InvalidColorization;
use crate::arguments::Arguments;

static LOGGER: OnceLock<Logger> = OnceLock::new();

/// The maximum number of warnings and errors from one source line per second.
const MOST_PER_SECOND: u32 = 20;
/// The maximum length of a message, in bytes.
const LONGEST_MESSAGE: usize = 2000;

struct Logger {
    /// The name of the ROS logger, which is derived from the node's name.
    name: String,
    level: LevelFilter,
    /// The level of the DDS libraries that have no level in `levels`.
    libraries: LevelFilter,
    /// Levels by logger name, which is the node's name or a prefix of a record's target.
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
    /// The rates of warnings and errors, by source file and line.
    rates: HashMap<(Option<&'static str>, Option<u32>), Rate>,
}

/// The number of records from a source line since a point in time.
struct Rate {
    since: Instant,
    records: u32,
}

/// Writes a line in place of standard error, for a program that displays a progress bar.
type Console = Box<dyn Fn(&str) + Send>;

/// The middleware crates. Their records keep their own logger names and have a separate level.
const LIBRARIES: [&str; 2] = ["ros2_client", "rustdds"];

/// Starts logging under the name of a node. Later calls in the same process have no effect.
///
/// `libraries` is the level of the DDS libraries if `arguments` does not set one.
///
/// # Errors
///
/// Returns an error if `RCUTILS_COLORIZED_OUTPUT` is invalid.
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
    // This fails if the process already has a logger, such as that of a test harness. That logger
    // is then kept.
    if log::set_logger(logger).is_ok() {
        let highest = arguments.logger_levels.iter().map(|(_, level)| *level).max();
        log::set_max_level(highest.unwrap_or(level).max(level));
    }
    Ok(())
}

/// Starts publishing the node's records on `/rosout`.
pub(crate) fn publish_to(rosout: NodeLoggingHandle) {
    with_outputs(|outputs| {
        outputs.rosout = Some(Arc::new(rosout));
        outputs.libraries_muted = false;
    });
}

/// Stops publishing on `/rosout`, because its writer keeps the DDS participant alive.
///
/// This also mutes the libraries: on shutdown, RustDDS logs an error because a loopback socket
/// leaves a multicast group that it has not joined.
pub(crate) fn stop_publishing() {
    with_outputs(|outputs| {
        outputs.rosout = None;
        outputs.libraries_muted = true;
    });
}

/// Makes the logger pass console lines to a function instead of writing them to standard error, for
/// a program that shows a progress bar. The call has no effect before [`start`].
///
/// # Examples
///
/// ```
/// ros_runtime::logging::write_console_through(|line| println!("{line}"));
/// ```
pub fn write_console_through(console: impl Fn(&str) + Send + 'static) {
    with_outputs(|outputs| outputs.console = Some(Box::new(console)));
}

fn with_outputs(change: impl FnOnce(&mut Outputs)) {
    if let Some(logger) = LOGGER.get() {
        change(&mut logger.lock());
    }
}

impl Logger {
    fn lock(&self) -> MutexGuard<'_, Outputs> {
        self.outputs.lock()
    }

    fn level_of(&self, target: &str) -> LevelFilter {
        let root = target.split("::").next().unwrap_or(target);
        let own = !LIBRARIES.contains(&root);
        let named = self.levels.iter().rev().find(|(logger, _)| {
            // A level applies to the named logger and to the loggers below it.
            let rest = target.strip_prefix(logger.as_str());
            let is_named = rest.is_some_and(|rest| rest.is_empty() || rest.starts_with("::"));
            is_named || (own && *logger == self.name)
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
        let own = !LIBRARIES.contains(&record.target().split("::").next().unwrap_or_default());
        let name = if own { self.name.as_str() } else { record.target() };
        let mut outputs = self.lock();
        if outputs.libraries_muted && !own {
            return;
        }
        let Some(suppressed) = outputs.admit(record, Instant::now()) else {
            return;
        };
        let mut message = shortened(record.args().to_string(), LONGEST_MESSAGE);
        if suppressed > 0 {
            message += &format!(" ({suppressed} similar messages suppressed)");
        }
        if self.to_console {
            let line = self.format.line(record, SystemTime::now(), name, &message);
            match &outputs.console {
                Some(console) => console(&line),
                // The node keeps running if the console is closed.
                // One write, so that lines of several nodes on one terminal do not mix.
                None => drop(std::io::stderr().write_all(format!("{line}\n").as_bytes())),
            }
        }
        // Release the lock first: RustDDS may log while it publishes, and logging takes the lock.
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

impl Outputs {
    /// Applies the rate limit. Returns `None` if the record is suppressed, and otherwise the number
    /// of records from the same source line that were suppressed before it.
    fn admit(&mut self, record: &Record, now: Instant) -> Option<u32> {
        if record.level() > Level::Warn {
            return Some(0);
        }
        let line = (record.file_static(), record.line());
        let rate = self.rates.entry(line).or_insert(Rate { since: now, records: 0 });
        let mut suppressed = 0;
        if now - rate.since >= Duration::from_secs(1) {
            suppressed = rate.records.saturating_sub(MOST_PER_SECOND);
            *rate = Rate { since: now, records: 0 };
        }
        rate.records = rate.records.saturating_add(1);
        (rate.records <= MOST_PER_SECOND).then_some(suppressed)
    }
}

/// Truncates a text that is longer than `bytes` bytes, at a character boundary, and replaces the
/// rest with `...`.
pub(crate) fn shortened(mut text: String, bytes: usize) -> String {
    if text.len() > bytes {
        let end = (0..=bytes).rev().find(|place| text.is_char_boundary(*place));
        text.truncate(end.unwrap_or(0));
        text.push_str("...");
    }
    text
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
            name: "camera".to_owned(),
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
    fn limits_the_rate_of_warnings_and_errors_from_each_line() {
        let mut outputs = Outputs::default();
        let mut admit = |level, line, now| {
            let record = Record::builder().level(level).line(Some(line)).build();
            outputs.admit(&record, now)
        };
        let start = Instant::now();
        for number in 0..1000 {
            let expected = (number < MOST_PER_SECOND).then_some(0);
            assert_eq!(admit(Level::Warn, 1, start), expected);
            assert_eq!(admit(Level::Info, 2, start), Some(0));
        }
        assert_eq!(admit(Level::Error, 3, start), Some(0), "another line");
        let later = start + Duration::from_secs(1);
        assert_eq!(admit(Level::Warn, 1, later), Some(1000 - MOST_PER_SECOND));
        assert_eq!(admit(Level::Warn, 1, later), Some(0));
    }

    #[test]
    fn truncates_long_texts_at_a_character_boundary() {
        for (bytes, expected) in [(4, "a\u{e9}b"), (3, "a\u{e9}..."), (2, "a..."), (0, "...")] {
            assert_eq!(shortened("a\u{e9}b".to_owned(), bytes), expected);
        }
    }

    #[test]
    fn libraries_and_the_node_have_separate_levels() {
        let default = logger(LevelFilter::Info, &[]);
        assert_eq!(default.level_of("camera::driver"), LevelFilter::Info);
        assert_eq!(default.level_of("rustdds::rtps"), LevelFilter::Error);
        let with_debug = logger(LevelFilter::Warn, &[("rustdds", LevelFilter::Debug)]);
        assert_eq!(with_debug.level_of("rustdds::rtps"), LevelFilter::Debug);
        assert_eq!(with_debug.level_of("ros_runtime::node"), LevelFilter::Warn);
        let of_another = logger(LevelFilter::Warn, &[("rust", LevelFilter::Debug)]);
        assert_eq!(of_another.level_of("rustdds::rtps"), LevelFilter::Error);
        let by_name = logger(LevelFilter::Info, &[("camera", LevelFilter::Error)]);
        assert_eq!(by_name.level_of("ros_runtime::node"), LevelFilter::Error);
    }
}
