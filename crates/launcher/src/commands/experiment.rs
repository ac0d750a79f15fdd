//! `evac bench`, `ablation`, `reproduce`, `soak`: the programs of the crate `experiments`, which take the
//! rest of the command line.

use std::{
    os::unix::process::CommandExt,
    process::{self, ExitCode},
};

use anyhow::Context;
use clap::{Arg, ArgMatches, Command};

use crate::programs;

/// The command, its program, and what it does.
const EXPERIMENTS: [(&str, &str, &str); 4] = [
    ("bench", "benchmark", "Measure speed: update, step over DDS, training, simulator"),
    ("ablation", "ablation", "Train without each ingredient of the preset robust"),
    ("reproduce", "reproduction", "Train and test everything that the results show"),
    ("soak", "soak", "A training of a million steps over a bad network"),
];

pub fn commands() -> impl Iterator<Item = Command> {
    EXPERIMENTS.into_iter().map(|(name, _, about)| {
        let arguments =
            Arg::new("arguments").num_args(0..).trailing_var_arg(true).allow_hyphen_values(true);
        Command::new(name).about(about).disable_help_flag(true).arg(arguments)
    })
}

/// Becomes the program.
pub fn run(name: &str, matches: &ArgMatches) -> anyhow::Result<ExitCode> {
    let program = EXPERIMENTS.iter().find(|(command, ..)| *command == name);
    let (_, program, _) = program.context("no such command")?;
    let arguments = matches.get_many::<String>("arguments").into_iter().flatten();
    let mut command = process::Command::new(programs::find(program)?);
    // candle's matrix product, which the update is measured by, on one thread.
    let error = command.env("RAYON_NUM_THREADS", "1").args(arguments).exec();
    Err(error).context(*program)
}
