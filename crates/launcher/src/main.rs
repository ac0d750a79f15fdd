//! `evac`: starts, supervises and stops the nodes. Scripts, ROS launch files and containers run it.
//!
//! - [`programs`]: finds the nodes and the experiments.
//! - [`parameters`]: queries a node for its parameters.
//! - [`command_line`]: turns these parameters into command-line options.
//! - [`children`]: nodes as child processes.
//! - [`readiness`]: waits until nodes report that they are ready.
//! - [`supervision`]: restarts nodes that fail, and stops all nodes at the end.
//! - [`commands`]: the commands of `evac`.

mod children;
mod command_line;
mod commands;
mod parameters;
mod programs;
mod readiness;
mod supervision;

use std::process::ExitCode;

fn main() -> ExitCode {
    match commands::run(std::env::args_os()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("evac: {error:#}");
            ExitCode::FAILURE
        }
    }
}
