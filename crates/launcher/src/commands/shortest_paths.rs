//! The full-knowledge shortest paths of an evaluation. The simulator computes them, because the
//! agent does not know the room.

use std::{io::Write, path::Path, process::Command};

use anyhow::{Context, ensure};
use task::seeds::{MIXED, Purpose, episode_seed};
use tempfile::NamedTempFile;

/// Returns a temporary file with the output of `sim_node oracle` for an evaluation with this seed
/// and number of episodes, or `None` for the scenario `mixed` or an evaluation without episodes.
///
/// # Errors
///
/// Returns the error message of the simulator if it fails, or an error if it cannot be started or
/// a file cannot be written.
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
        writeln!(seeds, "{}", episode_seed(Purpose::Evaluation, seed, episode))?;
    }
    let output = Command::new(simulator)
        .args(["oracle", "--scenario", scenario, "--seeds"])
        .arg(seeds.path())
        .args(simulator_arguments)
        .output()
        .with_context(|| format!("cannot start {}", simulator.display()))?;
    ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr).trim());
    let mut file = NamedTempFile::new()?;
    file.write_all(&output.stdout)?;
    Ok(Some(file))
}

/// Returns the arguments that pass the file from [`compute`] to the agent.
pub fn arguments(file: Option<&NamedTempFile>) -> Vec<String> {
    match file {
        Some(file) => vec!["--oracle".to_owned(), file.path().display().to_string()],
        None => Vec::new(),
    }
}
