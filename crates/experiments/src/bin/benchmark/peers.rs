//! Other people's software on the same machine in the same run: `tests/peers/benchmark`.

use std::{
    fs,
    path::PathBuf,
    process::{Command, Stdio},
};

use anyhow::{Context, ensure};
use experiments::{Nodes, repository};
use learning::{
    observation::input_size,
    settings::{Preset, Settings},
};
use serde_json::Value;

/// What is not installed, or was not asked for, is `None`.
#[derive(Default)]
pub struct PeerFigures {
    /// For each preset.
    pub torch_update_us: Vec<(Preset, f64)>,
    pub sb3_steps_per_s: Option<f64>,
    pub cyclone_rtt_us: Option<f64>,
    pub ddsperf_rtt_us: Option<f64>,
}

/// A Python that has the peers' packages, in a virtual environment that is made if need be.
fn python() -> anyhow::Result<PathBuf> {
    let requirements = repository().join("tests/peers/benchmark/requirements.txt");
    let environment = repository().join(".venv-bench");
    let (python, installed) =
        (environment.join("bin/python"), environment.join("requirements.txt"));
    let wanted = fs::read(&requirements).with_context(|| requirements.display().to_string())?;
    // What is installed, so that the next run need not ask.
    if fs::read(&installed).is_ok_and(|found| found == wanted) {
        return Ok(python);
    }
    let made = Command::new("python3").args(["-m", "venv"]).arg(&environment).status();
    let made = made.context("python3 not found: install Python 3.11 or later for --peers")?;
    ensure!(made.success(), "python3 makes no virtual environments (Debian: install python3-venv)");
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--requirement"]).arg(&requirements);
    ensure!(install.status()?.success(), "pip cannot install {}", requirements.display());
    fs::write(&installed, wanted)?;
    Ok(python)
}

/// Measures the peers.
pub fn measure() -> anyhow::Result<PeerFigures> {
    let python = &python()?;
    let nodes = Nodes::new();
    let run = |script: &str, arguments: &[String]| {
        let path = repository().join("tests/peers/benchmark").join(script);
        measure_script(nodes.command(python).arg(path).args(arguments))
    };
    let mut torch_update_us = Vec::new();
    for preset in Preset::ALL {
        let figures = run("torch_update.py", &form(&preset.settings()))?;
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
    /// PyTorch's update of a network and batch of the preset's form.
    pub fn torch_update_us(&self, preset: Preset) -> Option<f64> {
        self.torch_update_us.iter().find(|(of, _)| *of == preset).map(|(_, time)| *time)
    }
}

/// The form of network and batch as `torch_update.py` takes it.
fn form(settings: &Settings) -> Vec<String> {
    let hidden = settings.network.hidden_layers.iter().map(usize::to_string);
    ["--inputs".to_owned(), input_size(settings.network.observation_frames).to_string()]
        .into_iter()
        .chain(["--batch".to_owned(), settings.replay.batch_size.to_string()])
        .chain(settings.target.double_q.then(|| "--double".to_owned()))
        .chain(["--hidden".to_owned()])
        .chain(hidden)
        .collect()
}

/// The figures that a script prints as JSON.
fn measure_script(command: &mut Command) -> anyhow::Result<Value> {
    let output = command.stderr(Stdio::inherit()).output()?;
    anyhow::ensure!(output.status.success(), "{command:?} ended with {}", output.status);
    Ok(serde_json::from_slice(&output.stdout)?)
}
