//! The policy that `train.sh` trains by default, over DDS: its robustness, and the check that it is
//! the policy of the training run in this process.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use anyhow::{Context, bail, ensure};
use learning::run::RunDirectory;
use report::numbers::decimal;
use task::RobustnessRow;

/// The scenario in which the robustness is evaluated: the one with the longest paths.
const SCENARIO: &str = "concave";
const EPISODES: &str = "1000";

/// Trains the policy with `evac train` and evaluates its robustness with `evac evaluate`, unless
/// an earlier run did so with the same policy. `model` is the model file of the same training run in this
/// process. Returns the directory of the robustness evaluation.
///
/// # Errors
///
/// Returns an error if `evac` fails or the weights differ from those of `model`.
pub fn robustness(out: &Path, model: &Path) -> anyhow::Result<PathBuf> {
    let run = out.join("over-dds").join("run");
    let robustness = out.join("over-dds").join("robustness");
    fs::create_dir_all(out.join("over-dds"))?;
    let read = |path: &Path| fs::read(path).with_context(|| path.display().to_string());
    let expected = read(model)?;
    if read(&run.join(RunDirectory::MODEL)).ok().as_ref() != Some(&expected) {
        for old in [&run, &robustness].into_iter().filter(|old| old.exists()) {
            fs::remove_dir_all(old).with_context(|| old.display().to_string())?;
        }
        println!("training over DDS");
        evac(&["train", "--seed", "0", "--evaluation-episodes", "0", "--out"], &run)?;
    }
    ensure!(
        read(&run.join(RunDirectory::MODEL))? == expected,
        "the policy trained over DDS differs from {}",
        model.display()
    );
    if !robustness.join("robustness.json").exists() {
        println!("evaluating the robustness over DDS");
        let model = run.display().to_string();
        let arguments = [
            ["evaluate", "--robustness", "--model", &model],
            ["--scenario", SCENARIO, "--episodes", EPISODES],
        ];
        evac(&[arguments.as_flattened(), &["--out"]].concat(), &robustness)?;
    }
    Ok(robustness)
}

/// Runs `evac` with `directory` as its last argument, and writes its output to a log file next to
/// the directory.
fn evac(arguments: &[&str], directory: &Path) -> anyhow::Result<()> {
    let log = directory.with_extension("log");
    let file = File::create(&log).with_context(|| log.display().to_string())?;
    let evac = std::env::current_exe()?.with_file_name("evac");
    let mut command = Command::new(&evac);
    command.args(arguments).arg(directory).stdin(Stdio::null());
    command.stdout(file.try_clone()?).stderr(file);
    let status = command.status().with_context(|| evac.display().to_string())?;
    if !status.success() {
        bail!("evac {} failed ({status}); log: {}", arguments[0], log.display());
    }
    Ok(())
}

/// Returns the robustness in `robustness.json` as a Markdown table.
///
/// # Errors
///
/// Returns an error if the file cannot be read or parsed.
pub fn table(directory: &Path) -> anyhow::Result<String> {
    let path = directory.join("robustness.json");
    let context = || path.display().to_string();
    let rows: Vec<RobustnessRow> =
        serde_json::from_str(&fs::read_to_string(&path).with_context(context)?)
            .with_context(context)?;
    let mut table = "| perturbation | level | success rate | blocked moves per 100 steps | \
                     collision-free episodes | mean steps |\n|---|---|---|---|---|---|\n"
        .to_owned();
    for row in rows {
        let percent = |share: f64| decimal(100.0 * share, 1) + "\u{a0}%";
        table += &format!(
            "| {} | {} | {} | {} | {} | {} |\n",
            row.perturbation,
            row.level,
            percent(row.success_rate),
            decimal(row.blocked_per_100_steps, 2),
            percent(row.collision_free_rate),
            row.mean_steps.map_or_else(String::new, |steps| decimal(steps, 1))
        );
    }
    Ok(table)
}
