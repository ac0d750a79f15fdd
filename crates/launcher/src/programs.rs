//! Finds the programs of the nodes and the experiments.

use std::{
    env,
    path::{Path, PathBuf},
};

use anyhow::{Context, bail};

/// Returns the path of a program in this workspace. Searches the directory of `evac`, then the
/// prefixes in `AMENT_PREFIX_PATH`.
///
/// # Errors
///
/// Returns an error if the program is not found.
pub fn find(name: &str) -> anyhow::Result<PathBuf> {
    let evac = env::current_exe().context("cannot determine the path of evac")?;
    let beside_evac = evac.parent().map(|directory| directory.join(name));
    // colcon installs programs as lib/PACKAGE/PROGRAM; here, both have the same name.
    let prefixes = env::var_os("AMENT_PREFIX_PATH").unwrap_or_default();
    let installed =
        env::split_paths(&prefixes).map(|prefix| prefix.join("lib").join(name).join(name));
    let candidates: Vec<PathBuf> = beside_evac.into_iter().chain(installed).collect();
    match candidates.iter().find(|path| path.is_file()) {
        Some(path) => Ok(path.clone()),
        None => bail!(
            "program {name} not found (searched: {}); the scripts in launch_scripts build it",
            joined(&candidates)
        ),
    }
}

fn joined(paths: &[PathBuf]) -> String {
    let paths: Vec<String> = paths.iter().map(|path| Path::display(path).to_string()).collect();
    paths.join(", ")
}
