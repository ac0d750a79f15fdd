//! The fewest steps out of the rooms of a test, which only the simulator can tell.

use std::{io::Write, path::Path, process::Command};

use anyhow::{Context, ensure};
use task::seeds::{MIXED, Purpose, episode_seed};
use tempfile::NamedTempFile;

/// What `sim_node oracle` has printed, in a file that goes with this value.
pub struct FewestStepsFile(NamedTempFile);

impl FewestStepsFile {
    /// Has the simulator compute them for a test; none where each episode has a room of its own.
    pub fn compute(
        simulator: &Path,
        simulator_arguments: &[String],
        scenario: &str,
        seed: u64,
        episodes: u64,
    ) -> anyhow::Result<Option<FewestStepsFile>> {
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
        Ok(Some(FewestStepsFile(file)))
    }

    /// The agent's arguments.
    pub fn arguments(&self) -> [String; 2] {
        ["--oracle".to_owned(), self.0.path().display().to_string()]
    }
}
