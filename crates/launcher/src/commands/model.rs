//! The directory of a trained model.

use std::path::Path;

use anyhow::bail;

/// Returns an error unless `model`, the value of the parameter `model`, is a directory with a
/// trained model.
pub fn check(model: &str) -> anyhow::Result<()> {
    match model {
        "" => bail!("missing option --model DIR (expected: the directory of a training run)"),
        model if Path::new(model).join("config.yaml").is_file() => Ok(()),
        model => bail!("no trained model in {model} (config.yaml not found)"),
    }
}
