//! ROS arguments on the command line.
//!
//! In `node own arguments --ros-args -r from:=to -p name:=value -- more own arguments`, everything
//! between `--ros-args` and `--` (or the end) belongs to ROS, and the rest belongs to the program.
//! A command line can have several such blocks. The syntax is that of rcl (`rcl/arguments.h`).

use std::path::PathBuf;

use log::LevelFilter;
use thiserror::Error;

use crate::{
    escape::escaped,
    logging::level::parse_level,
    names::{Remap, RemapError},
    parameters::value::{Override, OverrideError},
    security::{EnclaveName, InvalidEnclaveName},
};

/// A command line, split into the program's arguments and the ROS arguments.
///
/// # Examples
///
/// ```
/// use ros_runtime::Arguments;
///
/// let line = ["node", "--verbose", "--ros-args", "-r", "image:=/front", "-p", "rate:=20.0"];
/// let arguments = Arguments::parse(line.map(str::to_owned))?;
/// assert_eq!(arguments.program, ["node", "--verbose"]);
/// assert_eq!(arguments.remaps[0].to, "/front");
/// assert_eq!(arguments.overrides[0].name, "rate");
/// # Ok::<(), ros_runtime::arguments::ArgumentsError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Arguments {
    /// The program's own arguments; the first one is the program's name.
    pub program: Vec<String>,
    /// The rules given with `-r`, in order: the first match wins.
    pub remaps: Vec<Remap>,
    /// The rules given with `-p`, in order: the last match wins.
    pub overrides: Vec<Override>,
    /// The files given with `--params-file`, in order: the last one wins. `-p` overrides the files.
    pub parameter_files: Vec<PathBuf>,
    /// `--log-level LEVEL`: the level of every logger without an individual level.
    pub log_level: Option<LevelFilter>,
    /// `--log-level LOGGER:=LEVEL`: the levels of individual loggers, in order.
    pub logger_levels: Vec<(String, LevelFilter)>,
    /// Whether to log to the console (`--enable-stdout-logs`), which is standard error, as in rcl.
    pub logs_to_console: bool,
    /// Whether to log to `/rosout` (`--enable-rosout-logs`).
    pub logs_to_rosout: bool,
    /// `--enclave`: the SROS2 enclave that contains the node's keys.
    pub enclave: EnclaveName,
}

impl Default for Arguments {
    fn default() -> Arguments {
        Arguments {
            program: Vec::new(),
            remaps: Vec::new(),
            overrides: Vec::new(),
            parameter_files: Vec::new(),
            log_level: None,
            logger_levels: Vec::new(),
            logs_to_console: true,
            logs_to_rosout: true,
            enclave: EnclaveName::default(),
        }
    }
}

/// The error returned for an invalid command line.
#[derive(Debug, Error, PartialEq)]
pub enum ArgumentsError {
    /// A flag at the end of its block lacks its value.
    #[error("'{flag}' needs a value: {flag} {example}")]
    MissingValue {
        /// The flag.
        flag: String,
        /// An example of a valid value.
        example: &'static str,
    },
    /// A flag is not a ROS argument.
    #[error(
        "unknown ROS argument '{}': expected -r, -p, --params-file, --log-level, --enclave, or \
         --enable- or --disable- followed by rosout-logs, stdout-logs or external-lib-logs",
        escaped(.0)
    )]
    Unknown(String),
    /// A remapping is invalid.
    #[error(transparent)]
    Remap(#[from] RemapError),
    /// A parameter override is invalid.
    #[error(transparent)]
    Override(#[from] OverrideError),
    /// A log level is unknown.
    #[error("unknown log level '{}': expected debug, info, warn, error or fatal", escaped(.0))]
    LogLevel(String),
    /// An argument is not valid UTF-8.
    #[error("argument '{}' is not valid UTF-8", escaped(.0))]
    NotUnicode(String),
    /// A log configuration file was given, but this crate writes no log files.
    #[error("--log-config-file '{}' is not supported: the node writes no log files", escaped(.0))]
    LogConfigFile(String),
    /// An enclave name is invalid.
    #[error("--enclave: {0}")]
    Enclave(#[from] InvalidEnclaveName),
}

impl Arguments {
    /// Parses the command line of this process.
    ///
    /// # Errors
    ///
    /// Returns an error if an argument is not valid UTF-8 or if [`Arguments::parse`] fails.
    pub fn from_environment() -> Result<Arguments, ArgumentsError> {
        let items: Result<Vec<String>, _> =
            std::env::args_os().map(|item| item.into_string()).collect();
        Arguments::parse(
            items.map_err(|item| ArgumentsError::NotUnicode(item.display().to_string()))?,
        )
    }

    /// Parses a command line; its first item is the program's name.
    ///
    /// # Errors
    ///
    /// Returns an error if a ROS argument is unknown or if its value is missing or invalid.
    pub fn parse(
        command_line: impl IntoIterator<Item = String>,
    ) -> Result<Arguments, ArgumentsError> {
        let mut arguments = Arguments::default();
        let mut items = command_line.into_iter();
        let mut in_block = false;
        while let Some(item) = items.next() {
            match (in_block, item.as_str()) {
                (_, "--ros-args") => in_block = true,
                (true, "--") => in_block = false,
                (true, _) => arguments.parse_flag(item, &mut items)?,
                (false, _) => arguments.program.push(item),
            }
        }
        Ok(arguments)
    }

    fn parse_flag(
        &mut self,
        flag: String,
        rest: &mut impl Iterator<Item = String>,
    ) -> Result<(), ArgumentsError> {
        let mut value = |example| {
            rest.next()
                .filter(|value| value != "--")
                .ok_or_else(|| ArgumentsError::MissingValue { flag: flag.clone(), example })
        };
        match flag.as_str() {
            "-r" | "--remap" => self.remaps.push(value("from:=to")?.parse()?),
            "-p" | "--param" => self.overrides.push(value("name:=value")?.parse()?),
            "--params-file" => self.parameter_files.push(value("FILE.yaml")?.into()),
            "--log-level" => self.parse_log_level(&value("info")?)?,
            "-e" | "--enclave" => self.enclave = value("/enclave")?.parse()?,
            "--log-config-file" => return Err(ArgumentsError::LogConfigFile(value("FILE")?)),
            "--enable-stdout-logs" => self.logs_to_console = true,
            "--disable-stdout-logs" => self.logs_to_console = false,
            "--enable-rosout-logs" => self.logs_to_rosout = true,
            "--disable-rosout-logs" => self.logs_to_rosout = false,
            // These flags control log files, which this crate does not write.
            "--enable-external-lib-logs" | "--disable-external-lib-logs" => {}
            _ => return Err(ArgumentsError::Unknown(flag)),
        }
        Ok(())
    }

    fn parse_log_level(&mut self, value: &str) -> Result<(), ArgumentsError> {
        let level =
            |name: &str| parse_level(name).ok_or_else(|| ArgumentsError::LogLevel(name.to_owned()));
        match value.split_once(":=") {
            Some((logger, name)) => self.logger_levels.push((logger.to_owned(), level(name)?)),
            None => self.log_level = Some(level(value)?),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::parameters::ParameterValue;

    fn parse(line: &str) -> Result<Arguments, ArgumentsError> {
        Arguments::parse(line.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn separates_ros_arguments_from_the_programs_own() {
        let arguments = parse(
            "node train --ros-args -p episodes:=5 -r __ns:=/one -- --verbose --ros-args -p x:=1.5",
        )
        .unwrap();
        assert_eq!(arguments.program, ["node", "train", "--verbose"]);
        assert_eq!(arguments.overrides.len(), 2);
        assert_eq!(arguments.overrides[0].value, ParameterValue::Integer(5));
        assert_eq!(arguments.overrides[1].value, ParameterValue::Double(1.5));
        assert_eq!(arguments.remaps.len(), 1);
    }

    proptest! {
        /// Without `--ros-args`, every argument belongs to the program.
        #[test]
        fn rejects_any_invalid_command_line_with_a_one_line_error(
            items in prop::collection::vec(
                prop_oneof![
                    Just("--ros-args".to_owned()),
                    prop::sample::select(vec![
                        "-r", "-p", "--", "--log-level", "--params-file", "-e",
                    ])
                    .prop_map(str::to_owned),
                    "[a-z_~/]{0,6}(:=)?[-a-z0-9./:\\[\\]{},' ]{0,8}",
                    "(?s).{0,12}",
                ],
                0..8,
            ),
        ) {
            let parsed = Arguments::parse(items.clone());
            if let Err(error) = &parsed {
                prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error);
            }
            if !items.iter().any(|item| item == "--ros-args") {
                prop_assert_eq!(parsed.map(|arguments| arguments.program), Ok(items));
            }
        }
    }

    #[test]
    fn log_levels_are_global_or_per_logger() {
        let arguments = parse("n --ros-args --log-level warn --log-level rustdds:=DEBUG").unwrap();
        assert_eq!(arguments.log_level, Some(LevelFilter::Warn));
        assert_eq!(arguments.logger_levels, [("rustdds".to_owned(), LevelFilter::Debug)]);
    }

    #[test]
    fn enables_and_disables_log_outputs() {
        let arguments = parse("n").unwrap();
        assert!(arguments.logs_to_console && arguments.logs_to_rosout);
        let line = "n --ros-args --disable-rosout-logs --disable-stdout-logs --enable-stdout-logs";
        let arguments = parse(&format!("{line} --disable-external-lib-logs")).unwrap();
        assert!(arguments.logs_to_console && !arguments.logs_to_rosout);
    }

    /// As in rcl, the enclave is stored even without security.
    #[test]
    fn the_last_enclave_wins() {
        let arguments = parse("n --ros-args -e /one --enclave /robot/two").unwrap();
        assert_eq!(arguments.enclave, "/robot/two".parse().unwrap());
    }

    #[test]
    fn errors_name_the_invalid_argument() {
        for (line, expected) in [
            ("n --ros-args -r", "'-r' needs a value: -r from:=to"),
            ("n --ros-args -p --", "'-p' needs a value: -p name:=value"),
            ("n --ros-args --nonsense", "unknown ROS argument '--nonsense'"),
            ("n --ros-args --log-level loud", "unknown log level 'loud'"),
            ("n --ros-args -r abc", "couldn't parse the remapping 'abc'"),
            ("n --ros-args -p abc", "couldn't parse the parameter override 'abc'"),
            ("n --ros-args -e x", "'x' is not an enclave name: expected"),
            ("n --ros-args --log-config-file x", "writes no log files"),
        ] {
            let message = parse(line).unwrap_err().to_string();
            assert!(message.contains(expected), "{line}: {message}");
        }
    }

    #[test]
    fn errors_escape_the_arguments_that_they_quote() {
        for (arguments, expected) in [
            (
                ["--a\r\nb", ""],
                "unknown ROS argument '--a\\r\\nb': expected -r, -p, --params-file, --log-level, \
                 --enclave, or --enable- or --disable- followed by rosout-logs, stdout-logs or \
                 external-lib-logs",
            ),
            (
                ["--log-level", "loud\n"],
                r"unknown log level 'loud\n': expected debug, info, warn, error or fatal",
            ),
            (
                ["--log-config-file", "a\nb"],
                r"--log-config-file 'a\nb' is not supported: the node writes no log files",
            ),
            (
                ["-e", "/a\nb"],
                "--enclave: '/a\\nb' is not an enclave name: expected '/' or an absolute name such \
                 as '/robot/camera'",
            ),
            (
                ["-p", "a\nb"],
                "couldn't parse the parameter override 'a\\nb': expected 'name:=value' or \
                 'node:name:=value' with a value in YAML, such as 3, 0.5, true, text or [1.0, 2.0]",
            ),
            (
                ["-r", "a\nb"],
                "couldn't parse the remapping 'a\\nb': expected 'from:=to', 'node:from:=to', \
                 '__node:=name' or '__ns:=/namespace'",
            ),
        ] {
            let line = ["n", "--ros-args"].into_iter().chain(arguments).map(str::to_owned);
            assert_eq!(Arguments::parse(line).unwrap_err().to_string(), expected);
        }
        let encoding = ArgumentsError::NotUnicode("\u{fffd}\n".to_owned()).to_string();
        assert_eq!(encoding, "argument '\u{fffd}\\n' is not valid UTF-8");
    }
}
