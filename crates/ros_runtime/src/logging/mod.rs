//! Logging: the `log` crate's records on the console in ROS's format, and on `/rosout`.
//!
//! What this project's own crates say is the node's and goes to both. Libraries speak on the
//! console only, and by default only when something is wrong: their warnings are about the wire
//! and come by the thousand. `--log-level rustdds:=debug` opens one of them.
//!
//! Whoever is in the network can make a node complain thousands of times a second. So warnings and
//! errors of one line of the program are heard [`MOST_PER_SECOND`] times a second, and no message is
//! longer than [`LONGEST_MESSAGE`].

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

/// How many warnings and errors of one line of the program are heard in a second.
const MOST_PER_SECOND: u32 = 20;
/// The bytes that are heard of a message.
const LONGEST_MESSAGE: usize = 2000;

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
    /// Warnings and errors, by their lines in the program.
    said: HashMap<(Option<&'static str>, Option<u32>), Said>,
}

/// How often something was said since a moment.
struct Said {
    since: Instant,
    times: u32,
}

/// Writes a line where a progress bar stands: the bar steps aside.
type Console = Box<dyn Fn(&str) + Send>;

/// The crates of the middleware, whose records are not the node's own.
const LIBRARIES: [&str; 2] = ["ros2_client", "rustdds"];

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
    fn lock(&self) -> MutexGuard<'_, Outputs> {
        self.outputs.lock()
    }

    fn level_of(&self, target: &str) -> LevelFilter {
        let root = target.split("::").next().unwrap_or(target);
        let own = !LIBRARIES.contains(&root);
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
        let own = !LIBRARIES.contains(&record.target().split("::").next().unwrap_or_default());
        let name = if own { self.name.as_str() } else { record.target() };
        let mut outputs = self.lock();
        if outputs.libraries_muted && !own {
            return;
        }
        let Some(left_out) = outputs.admit(record, Instant::now()) else {
            return;
        };
        let mut message = shortened(record.args().to_string(), LONGEST_MESSAGE);
        if left_out > 0 {
            message += &format!(" (and {left_out} more of this kind)");
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

impl Outputs {
    /// Whether a record is heard: how many of its kind were not, since the last one that was.
    fn admit(&mut self, record: &Record, now: Instant) -> Option<u32> {
        if record.level() > Level::Warn {
            return Some(0);
        }
        let line = (record.file_static(), record.line());
        let said = self.said.entry(line).or_insert(Said { since: now, times: 0 });
        let mut left_out = 0;
        if now - said.since >= Duration::from_secs(1) {
            left_out = said.times.saturating_sub(MOST_PER_SECOND);
            *said = Said { since: now, times: 0 };
        }
        said.times = said.times.saturating_add(1);
        (said.times <= MOST_PER_SECOND).then_some(left_out)
    }
}

/// A text that is cut off after so many bytes, between two characters.
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
    fn whoever_complains_without_end_is_heard_now_and_then() {
        let mut outputs = Outputs::default();
        let mut heard = |level, line, now| {
            let record = Record::builder().level(level).line(Some(line)).build();
            outputs.admit(&record, now)
        };
        let start = Instant::now();
        for number in 0..1000 {
            let expected = (number < MOST_PER_SECOND).then_some(0);
            assert_eq!(heard(Level::Warn, 1, start), expected);
            assert_eq!(heard(Level::Info, 2, start), Some(0));
        }
        assert_eq!(heard(Level::Error, 3, start), Some(0), "another line");
        let later = start + Duration::from_secs(1);
        assert_eq!(heard(Level::Warn, 1, later), Some(1000 - MOST_PER_SECOND));
        assert_eq!(heard(Level::Warn, 1, later), Some(0));
    }

    #[test]
    fn what_is_too_long_is_cut_between_two_characters() {
        for (bytes, expected) in [(4, "a\u{e9}b"), (3, "a\u{e9}..."), (2, "a..."), (0, "...")] {
            assert_eq!(shortened("a\u{e9}b".to_owned(), bytes), expected);
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
