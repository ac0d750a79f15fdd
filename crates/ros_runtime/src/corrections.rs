//! The RustDDS build in use: the published crate, or a copy with the patches in `patches/rustdds`.
//!
//! `launch_scripts/setup.sh` applies the patches to a copy of the crate. A program compiles with
//! and without them, so it detects the patches by the items that they add: the first patch adds the
//! associated constant `CORRECTIONS`, and the patch that announces type hashes adds a method. As
//! inherent items, they take precedence over the trait items with the same names in this module,
//! which are the fallback for the published crate.
//!
//! # Examples
//!
//! ```
//! use ros_runtime::corrections::{RUSTDDS, corrections, is_corrected};
//!
//! assert_eq!(RUSTDDS.ends_with("(corrected)"), is_corrected());
//! assert_eq!(corrections().count() > 0, is_corrected());
//! ```

use rustdds::{DomainParticipant, DomainParticipantBuilder};

/// Provides fallbacks for the items that the published crate lacks.
#[allow(dead_code, reason = "the patched crate's own items take precedence")]
pub(crate) trait Uncorrected: Sized {
    const CORRECTIONS: &'static str = "";

    /// Does nothing: the published crate cannot set the USER_DATA of endpoints.
    fn endpoint_user_data(self, _: impl Fn(&str, &str) -> Vec<u8> + Send + Sync + 'static) -> Self {
        self
    }
}

impl Uncorrected for DomainParticipant {}
impl Uncorrected for DomainParticipantBuilder {}

/// The RustDDS version and build, such as `RustDDS 0.15.1 (corrected)`.
pub const RUSTDDS: &str =
    if is_corrected() { "RustDDS 0.15.1 (corrected)" } else { "RustDDS 0.15.1 (uncorrected)" };

/// Returns whether this program was built with the patched crate.
pub const fn is_corrected() -> bool {
    !DomainParticipant::CORRECTIONS.is_empty()
}

/// Returns the text that `--version` prints after the program's name: the package version and
/// [`RUSTDDS`](crate::corrections::RUSTDDS).
///
/// # Examples
///
/// ```
/// let version: String = ros_runtime::version!();
/// assert!(version.ends_with("corrected)"));
/// ```
#[macro_export]
macro_rules! version {
    () => {
        format!("{}, {}", env!("CARGO_PKG_VERSION"), $crate::corrections::RUSTDDS)
    };
}

/// Returns the names of the applied patches, which are the file names in `patches/rustdds` without
/// `.patch`. The published crate has none.
pub fn corrections() -> impl Iterator<Item = &'static str> {
    DomainParticipant::CORRECTIONS.lines()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const REPOSITORY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

    /// Returns the names of the patches if setup.sh has prepared the patched copy, which Cargo then
    /// uses, and no names otherwise.
    fn expected() -> Vec<String> {
        if !fs::exists(format!("{REPOSITORY}/.cargo/corrected/config.toml")).unwrap() {
            return vec![];
        }
        let files = fs::read_dir(format!("{REPOSITORY}/patches/rustdds")).unwrap();
        let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> =
            names.filter_map(|name| name.strip_suffix(".patch").map(str::to_owned)).collect();
        names.sort();
        names
    }

    #[test]
    fn the_corrections_match_the_patches_in_the_repository() {
        assert_eq!(corrections().collect::<Vec<_>>(), expected());
        assert_eq!(is_corrected(), !expected().is_empty());
    }

    #[test]
    fn the_version_matches_the_lock_file() {
        let lock = fs::read_to_string(format!("{REPOSITORY}/Cargo.lock")).unwrap();
        let (_, package) = lock.split_once("name = \"rustdds\"\nversion = \"").unwrap();
        let (version, _) = package.split_once('"').unwrap();
        assert!(RUSTDDS.starts_with(&format!("RustDDS {version} (")), "{RUSTDDS}: {version}");
    }
}
