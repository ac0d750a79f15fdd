//! Where the nodes and the experiments are.

use std::{
    env,
    path::{Path, PathBuf},
};

use anyhow::{Context, bail};

/// A program of this workspace: beside this one, or where ROS has installed it.
pub fn find(name: &str) -> anyhow::Result<PathBuf> {
    let own = env::current_exe().context("this program does not know where it is")?;
    let beside = own.parent().map(|directory| directory.join(name));
    // lib/PACKAGE/PROGRAM, where package and program have one name.
    let prefixes = env::var_os("AMENT_PREFIX_PATH").unwrap_or_default();
    let installed =
        env::split_paths(&prefixes).map(|prefix| prefix.join("lib").join(name).join(name));
    let candidates: Vec<PathBuf> = beside.into_iter().chain(installed).collect();
    match candidates.iter().find(|path| path.is_file()) {
        Some(path) => Ok(path.clone()),
        None => bail!("{name} is not built: looked for {}", joined(&candidates)),
    }
}

fn joined(paths: &[PathBuf]) -> String {
    let paths: Vec<String> = paths.iter().map(|path| Path::display(path).to_string()).collect();
    paths.join(", ")
}
