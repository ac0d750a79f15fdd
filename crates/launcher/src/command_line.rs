//! Command-line options that are generated from the parameters of the nodes.

use clap::{Arg, ArgAction, ArgMatches, Command, builder::PossibleValuesParser};
use serde_json::Value;

use crate::parameters::{Parameter, Parameters, assignment};

/// Parameters that every ROS node has and that are not offered as options.
const HIDDEN: [&str; 2] = ["start_type_description_service", "use_sim_time"];

/// Adds an option for each parameter that does not have one in `command` yet. `heading` is the
/// heading above these options in `--help`.
pub fn with_parameters(
    command: Command,
    parameters: &Parameters,
    heading: &'static str,
) -> Command {
    let existing: Vec<String> =
        command.get_arguments().map(|arg| arg.get_id().to_string()).collect();
    let new = parameters.iter().filter(|parameter| {
        !existing.contains(&parameter.name) && !HIDDEN.contains(&parameter.name.as_str())
    });
    new.fold(command, |command, parameter| command.arg(option(parameter).help_heading(heading)))
}

/// Returns the option for a parameter: `--max-steps` for `max_steps`, with the alias `--max_steps`.
fn option(parameter: &Parameter) -> Arg {
    let name = &parameter.name;
    let long = name.replace(['_', '.'], "-");
    let mut help = parameter.description.clone();
    if let Some((low, high)) = parameter.range {
        help += &format!(" [{low} to {high}]");
    }
    match &parameter.default {
        Value::String(default) if default.is_empty() => {}
        Value::String(default) => help += &format!(" [default: {default}]"),
        default => help += &format!(" [default: {default}]"),
    }
    let arg = Arg::new(name.clone()).long(long.clone()).help(help).action(ArgAction::Set);
    let arg = if *name == long { arg } else { arg.alias(name.clone()) };
    match (&parameter.default, parameter.choices.is_empty()) {
        (Value::Bool(_), _) => arg
            .num_args(0..=1)
            .default_missing_value("true")
            .value_parser(PossibleValuesParser::new(["true", "false"])),
        (_, false) => arg.value_parser(PossibleValuesParser::new(&parameter.choices)),
        (_, true) => arg.value_name(value_name(&parameter.expected)).allow_negative_numbers(true),
    }
}

fn value_name(expected: &str) -> &'static str {
    match expected {
        "an integer" => "N",
        "a number" => "X",
        "a string" => "TEXT",
        _ => "LIST",
    }
}

/// Returns the ROS arguments (`-p NAME:=VALUE`) for the options on the command line that are
/// parameters in `parameters`, except for those that are also in `excluded`.
pub fn given_parameters(
    matches: &ArgMatches,
    parameters: &Parameters,
    excluded: Option<&Parameters>,
) -> Vec<String> {
    let is_excluded =
        |name: &str| excluded.is_some_and(|other| other.iter().any(|p| p.name == name));
    let included = parameters.iter().filter(|parameter| !is_excluded(&parameter.name));
    included
        .filter_map(|parameter| {
            let value = matches.try_get_one::<String>(&parameter.name).ok()??;
            Some(assignment(parameter, value))
        })
        .flatten()
        .collect()
}
