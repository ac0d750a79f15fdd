//! Other people's software on the same machine in the same run: `tests/peers/benchmark`.

use std::{
    path::Path,
    process::{Command, Stdio},
};

use evac_tests::{Nodes, repository};
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

/// Runs the peers by a Python that has their packages.
pub fn measure(python: &Path) -> anyhow::Result<PeerFigures> {
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
    let hidden = settings.hidden_layers.iter().map(usize::to_string);
    ["--inputs".to_owned(), input_size(settings.observation_frames).to_string()]
        .into_iter()
        .chain(["--batch".to_owned(), settings.batch_size.to_string()])
        .chain(settings.double_q.then(|| "--double".to_owned()))
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
