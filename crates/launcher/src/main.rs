//! `evac`: starts the nodes, watches them, and ends them. Scripts, ROS launch files and containers start
//! this.
//!
//! - [`programs`]: where the nodes and the experiments are.
//! - [`parameters`]: what options a node has, which it tells itself.
//! - [`command_line`]: the options of each command, made of them.
//! - [`children`], [`readiness`], [`supervision`]: the nodes as processes, which say when they are ready; they are started again, and end with this one.
//! - [`commands`]: what the program does.

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
