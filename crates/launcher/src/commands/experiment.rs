//! `evac bench`, `ablation`, `reproduce`, `camera-limit` and `soak`: the programs of the crate `experiments`. They
//! parse the rest of the command line themselves.

use std::{
    os::unix::process::CommandExt,
    process::{self, ExitCode},
};

use anyhow::Context;
use clap::{Arg, ArgMatches, Command};

use crate::programs;

/// Command, program and description.
const EXPERIMENTS: [(&str, &str, &str); 5] = [
    ("bench", "benchmark", "Measure the speed of updates, DDS steps, training and the simulator"),
    ("ablation", "ablation", "Train the preset robust with one change at a time"),
    ("reproduce", "reproduction", "Train and evaluate every policy of docs/results.md"),
    (
        "camera-limit",
        "camera_limit",
        "Estimate how short paths can be for a robot that sees only through its camera",
    ),
    ("soak", "soak", "Train for a million steps over an unreliable network"),
];

pub fn commands() -> impl Iterator<Item = Command> {
    EXPERIMENTS.into_iter().map(|(name, _, about)| {
        let arguments =
            Arg::new("arguments").num_args(0..).trailing_var_arg(true).allow_hyphen_values(true);
        Command::new(name).about(about).disable_help_flag(true).arg(arguments)
    })
}

/// Replaces this process with the program of the command `name`.
///
/// # Errors
///
/// Returns an error if the program is not found or cannot be executed.
pub fn run(name: &str, matches: &ArgMatches) -> anyhow::Result<ExitCode> {
    let program = EXPERIMENTS.iter().find(|(command, ..)| *command == name);
    let (_, program, _) = program.with_context(|| format!("{name}: unknown command"))?;
    let arguments = matches.get_many::<String>("arguments").into_iter().flatten();
    let mut command = process::Command::new(programs::find(program)?);
    // The benchmark's baseline is candle on one thread.
    let error = command.env("RAYON_NUM_THREADS", "1").args(arguments).exec();
    Err(error).with_context(|| format!("cannot execute {program}"))
}
