//! The console format of rcutils: `RCUTILS_CONSOLE_OUTPUT_FORMAT` and `RCUTILS_COLORIZED_OUTPUT`.

use std::{
    env,
    fmt::Write,
    io::IsTerminal,
    time::{SystemTime, UNIX_EPOCH},
};

use log::{Level, Record};
use thiserror::Error;

use crate::escape::escaped;

const DEFAULT: &str = "[{severity}] [{time}] [{name}]: {message}";

/// The error returned for an invalid `RCUTILS_COLORIZED_OUTPUT`.
#[derive(Debug, Error, PartialEq)]
#[error("RCUTILS_COLORIZED_OUTPUT is '{}': expected 0 or 1", escaped(.0))]
pub struct InvalidColorization(String);

/// The format of a line, and whether it is coloured by level.
#[derive(Debug)]
pub(super) struct Format {
    text: String,
    is_coloured: bool,
}

impl Format {
    /// Reads the format from the environment. By default, colours are used only on a terminal.
    pub(super) fn from_environment() -> Result<Format, InvalidColorization> {
        let variable = |name| env::var(name).ok().filter(|value| !value.is_empty());
        let text = variable("RCUTILS_CONSOLE_OUTPUT_FORMAT");
        let is_coloured = match variable("RCUTILS_COLORIZED_OUTPUT").as_deref() {
            None => std::io::stderr().is_terminal(),
            Some("0") => false,
            Some("1") => true,
            Some(other) => return Err(InvalidColorization(other.to_owned())),
        };
        Ok(Format::new(text.as_deref().unwrap_or(DEFAULT), is_coloured))
    }

    pub(super) fn new(text: &str, is_coloured: bool) -> Format {
        // A shell passes `\n` and `\t` as two characters each.
        let text = text.replace("\\n", "\n").replace("\\t", "\t");
        Format { text, is_coloured }
    }

    /// Formats a record. Unknown fields in braces are left unchanged.
    pub(super) fn line(
        &self,
        record: &Record,
        now: SystemTime,
        name: &str,
        message: &str,
    ) -> String {
        let since_epoch = now.duration_since(UNIX_EPOCH).unwrap_or_default();
        let mut line = String::new();
        if self.is_coloured {
            line += colour(record.level());
        }
        let mut rest = self.text.as_str();
        while let Some((before, field)) = rest.split_once('{') {
            line += before;
            let Some((field, after)) = field.split_once('}') else {
                rest = &rest[before.len()..];
                break;
            };
            rest = after;
            let written = match field {
                "severity" => write!(line, "{}", severity(record.level())),
                "name" => write!(line, "{name}"),
                "message" => write!(line, "{message}"),
                "function_name" => write!(line, "{}", record.module_path().unwrap_or_default()),
                "file_name" => write!(line, "{}", record.file().unwrap_or_default()),
                "line_number" => write!(line, "{}", record.line().unwrap_or_default()),
                "time" => {
                    let (seconds, fraction) = (since_epoch.as_secs(), since_epoch.subsec_nanos());
                    write!(line, "{seconds}.{fraction:09}")
                }
                "time_as_nanoseconds" => write!(line, "{}", since_epoch.as_nanos()),
                other => write!(line, "{{{other}}}"),
            };
            written.expect("writing to a String cannot fail");
        }
        line += rest;
        if self.is_coloured {
            line += "\x1b[0m";
        }
        line
    }
}

/// Returns the level to print. ROS has no trace level, so trace becomes debug.
fn severity(level: Level) -> Level {
    level.min(Level::Debug)
}

/// Returns the escape sequence with which rcutils colours a level.
fn colour(level: Level) -> &'static str {
    match severity(level) {
        Level::Error => "\x1b[31m",
        Level::Warn => "\x1b[33m",
        Level::Info => "\x1b[0m",
        Level::Debug | Level::Trace => "\x1b[32m",
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn line(format: &str, is_coloured: bool) -> String {
        let time = UNIX_EPOCH + Duration::new(1_700_000_000, 42);
        let record =
            Record::builder().level(Level::Warn).file(Some("node.rs")).line(Some(7)).build();
        Format::new(format, is_coloured).line(&record, time, "camera", "hello")
    }

    #[test]
    fn the_default_is_the_ros_format() {
        assert_eq!(line(DEFAULT, false), "[WARN] [1700000000.000000042] [camera]: hello");
    }

    #[test]
    fn replaces_known_fields_and_keeps_everything_else() {
        for (format, expected) in [
            ("{message} ({file_name}:{line_number})", "hello (node.rs:7)"),
            ("{time_as_nanoseconds}\\t{name}", "1700000000000000042\tcamera"),
            ("{nonsense} {message", "{nonsense} {message"),
            ("", ""),
        ] {
            assert_eq!(line(format, false), expected, "{format}");
        }
    }

    #[test]
    fn a_coloured_line_resets_its_colour() {
        assert_eq!(line("{severity}", true), "\x1b[33mWARN\x1b[0m");
    }

    #[test]
    fn the_error_escapes_the_value_that_it_quotes() {
        let error = InvalidColorization("a\nb".to_owned()).to_string();
        assert_eq!(error, r"RCUTILS_COLORIZED_OUTPUT is 'a\nb': expected 0 or 1");
    }
}
