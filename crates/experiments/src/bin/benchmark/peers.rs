//! Measures third-party software on the same machine and in the same run, with the scripts in
//! `tests/peers/benchmark`.

use std::{
    fs,
    path::PathBuf,
    process::{Command, Stdio},
};

use anyhow::{Context, ensure};
use experiments::{Nodes, repository};
use learning::{
    network::Shape,
    settings::{Preset, Settings},
};
use serde_json::Value;

/// Measurements of third-party software; `None` or empty for software that is not installed or was
/// not requested.
#[derive(Default)]
pub struct PeerFigures {
    /// PyTorch: median time per update for each preset, in microseconds.
    pub torch_update_us: Vec<(Preset, f64)>,
    /// Stable-Baselines3: environment steps per second, with one update per step.
    pub sb3_steps_per_s: Option<f64>,
    /// CycloneDDS from Python: median round-trip time, in microseconds.
    pub cyclone_rtt_us: Option<f64>,
    /// CycloneDDS's ddsperf: median round-trip time, in microseconds.
    pub ddsperf_rtt_us: Option<f64>,
}

/// Returns the path of the Python interpreter in the virtual environment `.venv-bench`. Creates the
/// environment and installs the packages first if they are missing or out of date.
fn python() -> anyhow::Result<PathBuf> {
    let requirements = repository().join("tests/peers/benchmark/requirements.txt");
    let environment = repository().join(".venv-bench");
    let (python, installed) =
        (environment.join("bin/python"), environment.join("requirements.txt"));
    let required = fs::read(&requirements).with_context(|| requirements.display().to_string())?;
    // A copy of the requirements marks a complete installation, so that the next run skips pip.
    if fs::read(&installed).is_ok_and(|found| found == required) {
        return Ok(python);
    }
    let status = Command::new("python3").args(["-m", "venv"]).arg(&environment).status();
    let status = status.context("python3 not found: install Python 3.11 or later for --peers")?;
    ensure!(status.success(), "cannot create a virtual environment (Debian: install python3-venv)");
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--requirement"]).arg(&requirements);
    let status = install.status()?;
    ensure!(status.success(), "pip cannot install the packages in {}", requirements.display());
    fs::write(&installed, required)?;
    Ok(python)
}

/// Installs the packages and measures everything.
pub fn measure() -> anyhow::Result<PeerFigures> {
    let python = &python()?;
    let nodes = Nodes::new();
    let run = |script: &str, arguments: &[String]| {
        let path = repository().join("tests/peers/benchmark").join(script);
        measure_script(nodes.command(python).arg(path).args(arguments))
    };
    let mut torch_update_us = Vec::new();
    for preset in Preset::ALL {
        let figures = run("torch_update.py", &torch_options(&preset.settings()))?;
        torch_update_us.extend(figures["torch_update_us"].as_f64().map(|time| (preset, time)));
    }
    Ok(PeerFigures {
        torch_update_us,
        sb3_steps_per_s: run("sb3_dqn.py", &[])?["sb3_steps_per_s"].as_f64(),
        cyclone_rtt_us: run("cyclone_round_trip.py", &[])?["cyclone_rtt_us"]["p50"].as_f64(),
        ddsperf_rtt_us: run("ddsperf.py", &[])?["ddsperf_rtt_us"].as_f64(),
    })
}

impl PeerFigures {
    /// Returns PyTorch's time per update with the preset's network and batch size, in microseconds.
    pub fn torch_update_us(&self, preset: Preset) -> Option<f64> {
        let figure = self.torch_update_us.iter().find(|(measured, _)| *measured == preset);
        figure.map(|(_, time)| *time)
    }
}

/// Returns the options of `torch_update.py` for the network and batch size in `settings`.
fn torch_options(settings: &Settings) -> Vec<String> {
    let Shape { inputs, parts, hidden_layers } = Shape::of(&settings.network);
    let hidden = hidden_layers.iter().map(usize::to_string);
    ["--inputs".to_owned(), inputs.to_string(), "--parts".to_owned(), parts.to_string()]
        .into_iter()
        .chain(["--batch".to_owned(), settings.replay.batch_size.to_string()])
        .chain(settings.target.double_q.then(|| "--double".to_owned()))
        .chain(["--hidden".to_owned()])
        .chain(hidden)
        .collect()
}

/// Runs a script and returns the JSON that it prints.
fn measure_script(command: &mut Command) -> anyhow::Result<Value> {
    let output = command.stderr(Stdio::inherit()).output()?;
    anyhow::ensure!(output.status.success(), "{command:?} failed ({})", output.status);
    Ok(serde_json::from_slice(&output.stdout)?)
}
