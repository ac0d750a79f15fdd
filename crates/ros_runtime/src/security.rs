//! SROS2: the keys with which a participant joins its domain.
//!
//! A keystore created by `ros2 security` contains enclaves, which are directories with the identity
//! and the signed permissions of a participant. The environment variables are the same as in rcl:
//!
//! | variable | values |
//! |---|---|
//! | `ROS_SECURITY_ENABLE` | `true`, `false` (default) |
//! | `ROS_SECURITY_KEYSTORE` | the keystore's directory |
//! | `ROS_SECURITY_STRATEGY` | `Enforce`, `Permissive` (default) |
//! | `ROS_SECURITY_ENCLAVE_OVERRIDE` | an enclave, which takes precedence over `--enclave` |
//!
//! rcl treats any other value of `ROS_SECURITY_ENABLE` or `ROS_SECURITY_STRATEGY` as the less
//! secure option; this crate returns an error.
//!
//! Without the feature `security`, a node refuses to start if the environment enables security.

use std::{
    path::{Path, PathBuf},
    str::FromStr,
};

use log::LevelFilter;
use rustdds::DomainParticipantBuilder;
use thiserror::Error;

use crate::{
    escape::{escaped, escaped_path},
    names::is_namespace,
};

/// The name of an enclave, such as `/robot/camera`; the default is `/`.
///
/// # Examples
///
/// ```
/// use ros_runtime::security::EnclaveName;
///
/// assert!("/robot/camera".parse::<EnclaveName>().is_ok());
/// assert!("camera".parse::<EnclaveName>().is_err());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EnclaveName(String);

/// The error returned for an invalid enclave name.
#[derive(Debug, Error, PartialEq)]
#[error(
    "'{}' is not an enclave name: expected '/' or an absolute name such as '/robot/camera'",
    escaped(.0)
)]
pub struct InvalidEnclaveName(String);

impl Default for EnclaveName {
    fn default() -> EnclaveName {
        EnclaveName("/".to_owned())
    }
}

impl FromStr for EnclaveName {
    type Err = InvalidEnclaveName;

    fn from_str(name: &str) -> Result<EnclaveName, InvalidEnclaveName> {
        if is_namespace(name) {
            Ok(EnclaveName(name.to_owned()))
        } else {
            Err(InvalidEnclaveName(name.to_owned()))
        }
    }
}

/// The security configuration of a participant.
///
/// # Examples
///
/// ```
/// use ros_runtime::security::{EnclaveName, Security};
///
/// let variables = |name: &str| (name == "ROS_SECURITY_ENABLE").then(|| "false".to_owned());
/// let security = Security::from_variables(&EnclaveName::default(), variables)?;
/// assert_eq!(security, Security::Off);
/// # Ok::<(), ros_runtime::security::SecurityError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Security {
    /// Security is disabled.
    #[default]
    Off,
    /// Security is enabled with the strategy `Permissive`, but keys are missing, so the participant
    /// joins without security.
    Missing(MissingKeys),
    /// The participant joins with the keys in this directory.
    Enclave(PathBuf),
}

/// The reason why keys are missing.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MissingKeys {
    /// `ROS_SECURITY_KEYSTORE` is not set.
    #[error(
        "ROS_SECURITY_KEYSTORE is not set: expected a directory created by \
         'ros2 security create_keystore'"
    )]
    Keystore,
    /// The keystore does not contain the enclave.
    #[error(
        "there is no enclave {}: expected a directory created by 'ros2 security create_enclave'",
        escaped_path(.0)
    )]
    Enclave(PathBuf),
    /// The enclave lacks a file.
    #[error("the enclave {} is incomplete: {file} is missing", escaped_path(.enclave))]
    File {
        /// The enclave's directory.
        enclave: PathBuf,
        /// The missing file.
        file: &'static str,
    },
}

/// The error returned if security is enabled but cannot be used.
#[derive(Debug, Error, PartialEq)]
pub enum SecurityError {
    /// The crate was built without the feature `security`.
    #[error(
        "ROS_SECURITY_ENABLE=true, but this node was built without security: expected a build with \
         the feature 'security'; see docs/security.md"
    )]
    NotBuilt,
    /// `ROS_SECURITY_ENABLE` is neither `true` nor `false`.
    #[error("ROS_SECURITY_ENABLE='{}': expected true or false", escaped(.0))]
    Enable(String),
    /// `ROS_SECURITY_STRATEGY` is unknown.
    #[error("ROS_SECURITY_STRATEGY='{}': expected Enforce or Permissive", escaped(.0))]
    Strategy(String),
    /// `ROS_SECURITY_ENCLAVE_OVERRIDE` is not an enclave name.
    #[error("ROS_SECURITY_ENCLAVE_OVERRIDE: {0}")]
    Override(#[from] InvalidEnclaveName),
    /// The enclave has a certificate revocation list, which RustDDS would ignore.
    #[error(
        "{}: RustDDS does not support certificate revocation lists; create a new keystore instead",
        escaped_path(.0)
    )]
    Revocations(PathBuf),
    /// Keys are missing and the strategy is `Enforce`.
    #[error("ROS_SECURITY_STRATEGY=Enforce, but {0}")]
    Missing(#[from] MissingKeys),
}

/// The files of an enclave. Some are links to files that all enclaves in the keystore share.
const FILES: [&str; 6] = [
    "identity_ca.cert.pem",
    "cert.pem",
    "key.pem",
    "permissions_ca.cert.pem",
    "governance.p7s",
    "permissions.p7s",
];

impl Security {
    /// Reads environment variables for a participant in `enclave`, unless
    /// `ROS_SECURITY_ENCLAVE_OVERRIDE` names another enclave.
    ///
    /// `variable` returns the value of a variable; an empty value counts as unset, as in rcl.
    ///
    /// # Errors
    ///
    /// Returns an error if a variable is invalid, if the enclave has a certificate revocation list,
    /// or if keys are missing and the strategy is `Enforce`.
    pub fn from_variables(
        enclave: &EnclaveName,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Security, SecurityError> {
        let variable = |name: &str| variable(name).filter(|value| !value.is_empty());
        match variable("ROS_SECURITY_ENABLE").as_deref() {
            None | Some("false") => return Ok(Security::Off),
            Some("true") => {}
            Some(other) => return Err(SecurityError::Enable(other.to_owned())),
        }
        let is_enforced = match variable("ROS_SECURITY_STRATEGY").as_deref() {
            None | Some("Permissive") => false,
            Some("Enforce") => true,
            Some(other) => return Err(SecurityError::Strategy(other.to_owned())),
        };
        let enclave = match variable("ROS_SECURITY_ENCLAVE_OVERRIDE") {
            None => enclave.clone(),
            Some(name) => name.parse()?,
        };
        let keystore = variable("ROS_SECURITY_KEYSTORE").ok_or(MissingKeys::Keystore);
        match keystore.and_then(|keystore| directory(keystore.as_ref(), &enclave)) {
            Ok(directory) => {
                let revocations = directory.join("crl.pem");
                if revocations.exists() {
                    return Err(SecurityError::Revocations(revocations));
                }
                Ok(Security::Enclave(directory))
            }
            Err(missing) if is_enforced => Err(missing.into()),
            Err(missing) => Ok(Security::Missing(missing)),
        }
    }

    /// Logs the directory with the keys, or warns that security is enabled but keys are missing.
    pub(crate) fn report(&self) {
        match self {
            Security::Off => {}
            Security::Missing(missing) => log::warn!(
                "starting without security: {missing}; ROS_SECURITY_STRATEGY=Enforce makes this an \
                 error"
            ),
            Security::Enclave(directory) => {
                log::info!("found the security directory {}", escaped_path(directory));
            }
        }
    }

    /// Returns the log level of the DDS libraries. With security, RustDDS logs an error for every
    /// message that arrives before its key and for every packet from a participant without keys.
    pub(crate) fn library_level(&self) -> LevelFilter {
        match self {
            Security::Off | Security::Missing(_) => LevelFilter::Error,
            Security::Enclave(_) => LevelFilter::Off,
        }
    }

    /// Adds the keys to a participant builder.
    pub(crate) fn secure(
        &self,
        builder: DomainParticipantBuilder,
    ) -> Result<DomainParticipantBuilder, SecurityError> {
        match self {
            Security::Off => Ok(builder),
            #[cfg(not(feature = "security"))]
            Security::Missing(_) | Security::Enclave(_) => Err(SecurityError::NotBuilt),
            #[cfg(feature = "security")]
            Security::Missing(_) => Ok(builder),
            #[cfg(feature = "security")]
            Security::Enclave(directory) => {
                // SROS2 keys have no password.
                let files = rustdds::DomainParticipantSecurityConfigFiles::with_ros_default_names(
                    directory,
                    String::new(),
                );
                Ok(builder.builtin_security(files))
            }
        }
    }
}

/// Returns the directory of an enclave if it contains all files.
fn directory(keystore: &Path, enclave: &EnclaveName) -> Result<PathBuf, MissingKeys> {
    let directory = keystore.join("enclaves").join(enclave.0.trim_start_matches('/'));
    if !directory.is_dir() {
        return Err(MissingKeys::Enclave(directory));
    }
    match FILES.into_iter().find(|file| !directory.join(file).is_file()) {
        None => Ok(directory),
        Some(file) => Err(MissingKeys::File { enclave: directory, file }),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn security(variables: &[(&str, &str)]) -> Result<Security, SecurityError> {
        Security::from_variables(&"/robot/camera".parse().unwrap(), |name| {
            variables.iter().find(|(key, _)| *key == name).map(|(_, value)| value.to_string())
        })
    }

    const ENABLE: (&str, &str) = ("ROS_SECURITY_ENABLE", "true");
    const ENFORCE: (&str, &str) = ("ROS_SECURITY_STRATEGY", "Enforce");

    #[test]
    fn security_is_off_by_default() {
        assert_eq!(security(&[]), Ok(Security::Off));
        let keystore = ("ROS_SECURITY_KEYSTORE", "/nowhere");
        for value in ["", "false"] {
            let variables = [("ROS_SECURITY_ENABLE", value), keystore, ENFORCE];
            assert_eq!(security(&variables), Ok(Security::Off));
        }
    }

    #[test]
    fn rejects_invalid_enclave_names() {
        for name in ["", "robot", "/robot/", "//", "/a b"] {
            let error = name.parse::<EnclaveName>().unwrap_err().to_string();
            assert!(error.contains("expected '/' or an absolute name"), "{error}");
        }
    }

    #[test]
    fn rejects_values_that_rcl_treats_as_the_less_secure_option() {
        for value in ["True", "1"] {
            let found = security(&[("ROS_SECURITY_ENABLE", value)]);
            assert_eq!(found, Err(SecurityError::Enable(value.to_owned())));
        }
        let found = security(&[ENABLE, ("ROS_SECURITY_STRATEGY", "enforce")]);
        assert_eq!(found, Err(SecurityError::Strategy("enforce".to_owned())));
        let found = security(&[ENABLE, ("ROS_SECURITY_ENCLAVE_OVERRIDE", "robot")]);
        assert!(matches!(found, Err(SecurityError::Override(_))), "{found:?}");
    }

    #[test]
    fn names_the_missing_keys_and_returns_an_error_with_enforce() {
        let keystore = tempfile::tempdir().unwrap();
        let path = keystore.path().to_str().unwrap();
        let named = ("ROS_SECURITY_KEYSTORE", path);
        let enclave = keystore.path().join("enclaves/robot/camera");

        let missing = |variables: &[(&str, &str)]| {
            let Ok(Security::Missing(missing)) = security(&[&[ENABLE], variables].concat()) else {
                panic!("no keys are missing with {variables:?}");
            };
            let enforced = security(&[&[ENABLE, ENFORCE], variables].concat());
            assert_eq!(enforced, Err(SecurityError::Missing(missing.clone())));
            missing
        };
        assert_eq!(missing(&[]), MissingKeys::Keystore);
        assert_eq!(missing(&[named]), MissingKeys::Enclave(enclave.clone()));
        fs::create_dir_all(&enclave).unwrap();
        for file in FILES {
            let expected = MissingKeys::File { enclave: enclave.clone(), file };
            assert_eq!(missing(&[named]), expected);
            fs::write(enclave.join(file), "").unwrap();
        }
        assert_eq!(security(&[ENABLE, ENFORCE, named]), Ok(Security::Enclave(enclave.clone())));
        let revocations = enclave.join("crl.pem");
        fs::write(&revocations, "").unwrap();
        assert_eq!(security(&[ENABLE, named]), Err(SecurityError::Revocations(revocations)));
    }

    #[test]
    fn the_override_takes_precedence_over_the_enclave() {
        let keystore = tempfile::tempdir().unwrap();
        let named = ("ROS_SECURITY_KEYSTORE", keystore.path().to_str().unwrap());
        for (name, expected) in [("/", ""), ("/other", "other")] {
            let found = security(&[ENABLE, named, ("ROS_SECURITY_ENCLAVE_OVERRIDE", name)]);
            let expected = keystore.path().join("enclaves").join(expected);
            assert_eq!(found, Ok(Security::Missing(MissingKeys::Enclave(expected))));
        }
    }

    #[test]
    fn errors_escape_the_values_and_paths_that_they_quote() {
        let error = |variables: &[(&str, &str)]| security(variables).unwrap_err().to_string();
        for (variables, expected) in [
            (
                &[("ROS_SECURITY_ENABLE", "a\nb")][..],
                r"ROS_SECURITY_ENABLE='a\nb': expected true or false",
            ),
            (
                &[ENABLE, ("ROS_SECURITY_STRATEGY", "a\nb")],
                r"ROS_SECURITY_STRATEGY='a\nb': expected Enforce or Permissive",
            ),
            (
                &[ENABLE, ("ROS_SECURITY_ENCLAVE_OVERRIDE", "a\nb")],
                "ROS_SECURITY_ENCLAVE_OVERRIDE: 'a\\nb' is not an enclave name: expected '/' or an \
                 absolute name such as '/robot/camera'",
            ),
            (
                &[ENABLE, ENFORCE, ("ROS_SECURITY_KEYSTORE", "/nowhere\n")],
                "ROS_SECURITY_STRATEGY=Enforce, but there is no enclave \
                 /nowhere\\n/enclaves/robot/camera: expected a directory created by \
                 'ros2 security create_enclave'",
            ),
        ] {
            assert_eq!(error(variables), expected);
        }
        let incomplete = MissingKeys::File { enclave: "/a\nb".into(), file: "key.pem" };
        let expected = r"the enclave /a\nb is incomplete: key.pem is missing";
        assert_eq!(incomplete.to_string(), expected);
        let revocations = SecurityError::Revocations("/a\nb/crl.pem".into()).to_string();
        assert!(revocations.starts_with(r"/a\nb/crl.pem: RustDDS"), "{revocations}");
    }
}
