//! Other people's software on the same machine in the same run: `tests/peers/benchmark`.

use std::{
    path::Path,
    process::{Command, Stdio},
};

use evac_tests::{Nodes, repository};
use serde_json::Value;

/// What is not installed, or was not asked for, is `None`.
#[derive(Default)]
pub struct PeerFigures {
    pub torch_update_us: Option<f64>,
    pub sb3_steps_per_s: Option<f64>,
    pub cyclone_rtt_us: Option<f64>,
    pub ddsperf_rtt_us: Option<f64>,
}

/// Runs the peers by a Python that has their packages.
pub fn measure(python: &Path) -> anyhow::Result<PeerFigures> {
    let nodes = Nodes::new();
    let run = |script: &str| {
        let path = repository().join("tests/peers/benchmark").join(script);
        measure_script(nodes.command(python).arg(path))
    };
    Ok(PeerFigures {
        torch_update_us: run("torch_update.py")?["torch_update_us"].as_f64(),
        sb3_steps_per_s: run("sb3_dqn.py")?["sb3_steps_per_s"].as_f64(),
        cyclone_rtt_us: run("cyclone_round_trip.py")?["cyclone_rtt_us"]["p50"].as_f64(),
        ddsperf_rtt_us: run("ddsperf.py")?["ddsperf_rtt_us"].as_f64(),
    })
}

/// The figures that a script prints as JSON.
fn measure_script(command: &mut Command) -> anyhow::Result<Value> {
    let output = command.stderr(Stdio::inherit()).output()?;
    anyhow::ensure!(output.status.success(), "{command:?} ended with {}", output.status);
    Ok(serde_json::from_slice(&output.stdout)?)
}
