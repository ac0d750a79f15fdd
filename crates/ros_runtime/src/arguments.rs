//! The ROS part of a command line.
//!
//! `node own arguments --ros-args -r from:=to -p name:=value -- more own arguments`: what stands
//! between `--ros-args` and `--` (or the end) is ROS's, everything else the program's. There may be
//! several such blocks. The grammar is rcl's (`rcl/arguments.h`).

use std::path::PathBuf;

use log::LevelFilter;
use thiserror::Error;

use crate::{
    logging::level::parse_level,
    names::{Remap, RemapError},
    parameters::value::{Override, OverrideError},
    security::{EnclaveName, InvalidEnclaveName},
};

/// A command line, taken apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Arguments {
    /// The program's own arguments, its name first.
    pub program: Vec<String>,
    /// `-r`, in the order given: the first that matches wins.
    pub remaps: Vec<Remap>,
    /// `-p`, in the order given: the last one wins.
    pub overrides: Vec<Override>,
    /// `--params-file`, in the order given: the last one wins, and `-p` wins over all files.
    pub parameter_files: Vec<PathBuf>,
    /// `--log-level LEVEL`, for every logger without one of its own.
    pub log_level: Option<LevelFilter>,
    /// `--log-level LOGGER:=LEVEL`.
    pub logger_levels: Vec<(String, LevelFilter)>,
    /// Whether records go to the console, which rcl calls stdout although it is standard error.
    pub logs_to_console: bool,
    /// Whether records go to `/rosout`.
    pub logs_to_rosout: bool,
    /// `--enclave`: whose keys the node has, where there is security.
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

/// Why a command line is not one of ROS's.
#[derive(Debug, Error, PartialEq)]
pub enum ArgumentsError {
    /// A flag at the end of its block.
    #[error("'{flag}' needs a value: {flag} {example}")]
    MissingValue {
        /// The flag.
        flag: String,
        /// What would be right.
        example: &'static str,
    },
    /// A flag that ROS does not have.
    #[error(
        "unknown ROS argument '{0}': between --ros-args and -- there may be -r, -p, --params-file, \
         --log-level, --enclave, --enable- and --disable- with rosout-logs, stdout-logs and external-lib-logs"
    )]
    Unknown(String),
    /// A remapping that is none.
    #[error(transparent)]
    Remap(#[from] RemapError),
    /// A parameter override that is none.
    #[error(transparent)]
    Override(#[from] OverrideError),
    /// A level that ROS does not have.
    #[error("unknown log level '{0}': expected debug, info, warn, error or fatal")]
    LogLevel(String),
    /// An argument in another encoding.
    #[error("the argument '{0}' is not in Unicode (UTF-8)")]
    NotUnicode(String),
    /// rcl's default logging has no such files, either.
    #[error("--log-config-file '{0}': these nodes write no log files that could be configured")]
    LogConfigFile(String),
    /// An enclave that cannot be.
    #[error("--enclave: {0}")]
    Enclave(#[from] InvalidEnclaveName),
}

impl Arguments {
    /// Takes the ROS arguments off this process's command line.
    pub fn from_environment() -> Result<Arguments, ArgumentsError> {
        let items: Result<Vec<String>, _> =
            std::env::args_os().map(|item| item.into_string()).collect();
        Arguments::parse(
            items.map_err(|item| ArgumentsError::NotUnicode(item.display().to_string()))?,
        )
    }

    /// Takes the ROS arguments off a command line; the first item is the program's name.
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
            // Log files, of which there are none.
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
    fn ros_arguments_are_taken_off_wherever_they_stand() {
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
        /// Whatever is typed, there is an answer; and without ROS's marker nothing is taken.
        #[test]
        fn any_command_line_has_an_answer(
            items in prop::collection::vec(
                prop_oneof![
                    Just("--ros-args".to_owned()),
                    prop::sample::select(vec!["-r", "-p", "--", "--log-level", "--params-file", "-e"])
                        .prop_map(str::to_owned),
                    "[a-z_~/]{0,6}(:=)?[-a-z0-9./:\\[\\]{},' ]{0,8}",
                    ".{0,12}",
                ],
                0..8,
            ),
        ) {
            let parsed = Arguments::parse(items.clone());
            if !items.iter().any(|item| item == "--ros-args") {
                prop_assert_eq!(parsed.map(|arguments| arguments.program), Ok(items));
            }
        }
    }

    #[test]
    fn levels_are_global_or_of_one_logger() {
        let arguments = parse("n --ros-args --log-level warn --log-level rustdds:=DEBUG").unwrap();
        assert_eq!(arguments.log_level, Some(LevelFilter::Warn));
        assert_eq!(arguments.logger_levels, [("rustdds".to_owned(), LevelFilter::Debug)]);
    }

    #[test]
    fn logs_go_where_they_are_sent() {
        let arguments = parse("n").unwrap();
        assert!(arguments.logs_to_console && arguments.logs_to_rosout);
        let line = "n --ros-args --disable-rosout-logs --disable-stdout-logs --enable-stdout-logs";
        let arguments = parse(&format!("{line} --disable-external-lib-logs")).unwrap();
        assert!(arguments.logs_to_console && !arguments.logs_to_rosout);
    }

    /// As in rcl, which keeps it even if there is no security.
    #[test]
    fn the_last_enclave_counts() {
        let arguments = parse("n --ros-args -e /one --enclave /robot/two").unwrap();
        assert_eq!(arguments.enclave, "/robot/two".parse().unwrap());
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (line, expected) in [
            ("n --ros-args -r", "'-r' needs a value: -r from:=to"),
            ("n --ros-args -p --", "'-p' needs a value: -p name:=value"),
            ("n --ros-args --nonsense", "unknown ROS argument '--nonsense'"),
            ("n --ros-args --log-level loud", "unknown log level 'loud'"),
            ("n --ros-args -r abc", "couldn't parse the remapping 'abc'"),
            ("n --ros-args -p abc", "couldn't parse the parameter override 'abc'"),
            ("n --ros-args -e x", "'x' is no enclave: expected"),
            ("n --ros-args --log-config-file x", "write no log files"),
        ] {
            let message = parse(line).unwrap_err().to_string();
            assert!(message.contains(expected), "{line}: {message}");
        }
    }
}
