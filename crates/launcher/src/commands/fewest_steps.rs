//! The fewest steps out of the rooms of an evaluation, which only the simulator can compute.

use std::{io::Write, path::Path, process::Command};

use anyhow::{Context, ensure};
use task::seeds::{MIXED, Purpose, episode_seed};
use tempfile::NamedTempFile;

/// The output of `sim_node oracle` for an evaluation of (seed, episodes), in a temporary file; none where
/// each episode has a scenario of its own.
pub fn compute(
    simulator: &Path,
    simulator_arguments: &[String],
    scenario: &str,
    (seed, episodes): (u64, u64),
) -> anyhow::Result<Option<NamedTempFile>> {
    if scenario == MIXED || episodes == 0 {
        return Ok(None);
    }
    let mut seeds = NamedTempFile::new()?;
    for episode in 0..u32::try_from(episodes)? {
        writeln!(seeds, "{}", episode_seed(Purpose::Test, seed, episode))?;
    }
    let output = Command::new(simulator)
        .args(["oracle", "--scenario", scenario, "--seeds"])
        .arg(seeds.path())
        .args(simulator_arguments)
        .output()
        .with_context(|| simulator.display().to_string())?;
    ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr).trim());
    let mut file = NamedTempFile::new()?;
    file.write_all(&output.stdout)?;
    Ok(Some(file))
}

/// The agent's arguments for that file.
pub fn arguments(file: Option<&NamedTempFile>) -> Vec<String> {
    match file {
        Some(file) => vec!["--oracle".to_owned(), file.path().display().to_string()],
        None => Vec::new(),
    }
}
