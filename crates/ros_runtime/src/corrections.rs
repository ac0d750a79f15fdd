//! Which RustDDS this program was built with: the published crate, or one with corrections.
//!
//! `launch_scripts/setup.sh` applies `patches/rustdds` to a copy of the crate. A program compiles with
//! and without them, so the crate itself has to tell which one it is: the first patch adds an
//! associated constant, and the one that sends type hashes a method. Where they are, they take
//! precedence over the items of the same names in [`Uncorrected`].

use rustdds::{DomainParticipant, DomainParticipantBuilder};

/// What the published crate lacks.
#[allow(dead_code, reason = "replaced by the crate's own items where it is corrected")]
pub(crate) trait Uncorrected: Sized {
    const CORRECTIONS: &'static str = "";

    /// Does nothing: there is no way to set USER_DATA.
    fn endpoint_user_data(self, _: impl Fn(&str, &str) -> Vec<u8> + Send + Sync + 'static) -> Self {
        self
    }
}

impl Uncorrected for DomainParticipant {}
impl Uncorrected for DomainParticipantBuilder {}

/// The version of RustDDS, and whether it is corrected: `RustDDS 0.15.1 (corrected)`.
pub const RUSTDDS: &str =
    if is_corrected() { "RustDDS 0.15.1 (corrected)" } else { "RustDDS 0.15.1 (uncorrected)" };

/// Whether this program was built with corrections.
pub const fn is_corrected() -> bool {
    !DomainParticipant::CORRECTIONS.is_empty()
}

/// What `--version` prints after a program's name: the version of its package and [`RUSTDDS`].
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

/// The names of the corrections, those of the files in `patches/rustdds`.
pub fn corrections() -> impl Iterator<Item = &'static str> {
    DomainParticipant::CORRECTIONS.lines()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const REPOSITORY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

    /// The names of the patches, if setup.sh has been run: cargo then builds with its copy.
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
    fn corrections_are_those_of_the_patches() {
        assert_eq!(corrections().collect::<Vec<_>>(), expected());
        assert_eq!(is_corrected(), !expected().is_empty());
    }

    #[test]
    fn the_version_is_that_of_the_lock_file() {
        let lock = fs::read_to_string(format!("{REPOSITORY}/Cargo.lock")).unwrap();
        let (_, package) = lock.split_once("name = \"rustdds\"\nversion = \"").unwrap();
        let (version, _) = package.split_once('"').unwrap();
        assert!(RUSTDDS.starts_with(&format!("RustDDS {version} (")), "{RUSTDDS}: {version}");
    }
}
