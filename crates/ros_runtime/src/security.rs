//! SROS2: with whose keys a participant joins its domain.
//!
//! A keystore, as `ros2 security` makes it, has an enclave for each participant: a directory with its
//! identity and its permissions, signed. The variables are rcl's: `ROS_SECURITY_ENABLE` (`true` or
//! `false`), `ROS_SECURITY_KEYSTORE`, `ROS_SECURITY_STRATEGY` (`Enforce` or `Permissive`, the default)
//! and `ROS_SECURITY_ENCLAVE_OVERRIDE`, which wins over `--enclave`. rcl takes any other value of the
//! two switches for the less secure one; here it is an error.
//!
//! It takes the feature `security`. Without it, a node that should be secure does not start.

use std::{
    path::{Path, PathBuf},
    str::FromStr,
};

use log::LevelFilter;
use rustdds::DomainParticipantBuilder;
use thiserror::Error;

use crate::names::is_namespace;

/// The name of an enclave: `/` or `/one/two`.
#[derive(Clone, Debug, PartialEq)]
pub struct EnclaveName(String);

/// Why a text does not name an enclave.
#[derive(Debug, Error, PartialEq)]
#[error("'{0}' is no enclave: expected '/' or an absolute name such as '/robot/camera'")]
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

/// What the environment says about security.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Security {
    /// Nothing is secured.
    #[default]
    Off,
    /// There should be keys, but there are none, and the strategy is `Permissive`: nothing is secured.
    Missing(MissingKeys),
    /// The participant joins with the keys in this directory.
    Enclave(PathBuf),
}

/// Why there are no keys.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MissingKeys {
    /// No keystore is named.
    #[error(
        "ROS_SECURITY_KEYSTORE is not set: expected a directory that 'ros2 security create_keystore' \
         has made"
    )]
    Keystore,
    /// The keystore has no such enclave.
    #[error(
        "there is no enclave {}: expected a directory that 'ros2 security create_enclave' has made",
        .0.display()
    )]
    Enclave(PathBuf),
    /// The enclave is not whole.
    #[error("the enclave {} is not whole: there is no {file}", .enclave.display())]
    File {
        /// Its directory.
        enclave: PathBuf,
        /// What is not in it.
        file: &'static str,
    },
}

/// Why a participant cannot be as secure as the environment wants it.
#[derive(Debug, Error, PartialEq)]
pub enum SecurityError {
    /// RustDDS was built without its part that needs OpenSSL.
    #[error(
        "ROS_SECURITY_ENABLE=true, but this node was built without security: expected a build with \
         the feature 'security', see docs/security.md"
    )]
    NotBuilt,
    /// A switch that is neither on nor off.
    #[error("ROS_SECURITY_ENABLE='{0}': expected true or false")]
    Enable(String),
    /// A strategy that ROS does not have.
    #[error("ROS_SECURITY_STRATEGY='{0}': expected Enforce or Permissive")]
    Strategy(String),
    /// An override that names no enclave.
    #[error("ROS_SECURITY_ENCLAVE_OVERRIDE: {0}")]
    Override(#[from] InvalidEnclaveName),
    /// What RustDDS would not follow.
    #[error("RustDDS does not follow {}: expected no list of revoked certificates", .0.display())]
    Revocations(PathBuf),
    /// The strategy is `Enforce`.
    #[error("ROS_SECURITY_STRATEGY=Enforce, but {0}")]
    Missing(#[from] MissingKeys),
}

/// What every enclave has; some of it are links to what the keystore has once.
const FILES: [&str; 6] = [
    "identity_ca.cert.pem",
    "cert.pem",
    "key.pem",
    "permissions_ca.cert.pem",
    "governance.p7s",
    "permissions.p7s",
];

impl Security {
    /// Reads the variables through a function, for a participant that is in this enclave unless it is
    /// overridden; an empty one counts as not set, as in rcl.
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

    /// Says what was found, or that the node is less secure than somebody may think.
    pub(crate) fn report(&self) {
        match self {
            Security::Off => {}
            Security::Missing(missing) => log::warn!(
                "nothing is secured: {missing}; ROS_SECURITY_STRATEGY=Enforce makes that an error"
            ),
            Security::Enclave(directory) => {
                log::info!("found the security directory {}", directory.display());
            }
        }
    }

    /// What libraries may say: secured, RustDDS calls it an error that a message comes before its
    /// key, and complains of every packet of somebody who has none.
    pub(crate) fn library_level(&self) -> LevelFilter {
        match self {
            Security::Off | Security::Missing(_) => LevelFilter::Error,
            Security::Enclave(_) => LevelFilter::Off,
        }
    }

    /// Gives a participant its keys.
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
                // The keys of sros2 have no password.
                let files = rustdds::DomainParticipantSecurityConfigFiles::with_ros_default_names(
                    directory,
                    String::new(),
                );
                Ok(builder.builtin_security(files))
            }
        }
    }
}

/// The directory of an enclave that is whole.
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
    fn nothing_is_secured_unless_somebody_asks_for_it() {
        assert_eq!(security(&[]), Ok(Security::Off));
        let keystore = ("ROS_SECURITY_KEYSTORE", "/nowhere");
        for value in ["", "false"] {
            let variables = [("ROS_SECURITY_ENABLE", value), keystore, ENFORCE];
            assert_eq!(security(&variables), Ok(Security::Off));
        }
    }

    #[test]
    fn what_is_no_enclave_is_refused() {
        for name in ["", "robot", "/robot/", "//", "/a b"] {
            let error = name.parse::<EnclaveName>().unwrap_err().to_string();
            assert!(error.contains("expected '/' or an absolute name"), "{error}");
        }
    }

    #[test]
    fn values_that_rcl_would_take_for_the_less_secure_one_are_refused() {
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
    fn what_is_missing_is_named_and_with_enforce_an_error() {
        let keystore = tempfile::tempdir().unwrap();
        let path = keystore.path().to_str().unwrap();
        let named = ("ROS_SECURITY_KEYSTORE", path);
        let enclave = keystore.path().join("enclaves/robot/camera");

        let missing = |variables: &[(&str, &str)]| {
            let Ok(Security::Missing(missing)) = security(&[&[ENABLE], variables].concat()) else {
                panic!("{variables:?} is not missing");
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
    fn the_override_wins() {
        let keystore = tempfile::tempdir().unwrap();
        let named = ("ROS_SECURITY_KEYSTORE", keystore.path().to_str().unwrap());
        for (name, expected) in [("/", ""), ("/other", "other")] {
            let found = security(&[ENABLE, named, ("ROS_SECURITY_ENCLAVE_OVERRIDE", name)]);
            let expected = keystore.path().join("enclaves").join(expected);
            assert_eq!(found, Ok(Security::Missing(MissingKeys::Enclave(expected))));
        }
    }
}
