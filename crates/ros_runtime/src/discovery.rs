//! Discovery: the DDS domain that a node joins and the networks that it uses.
//!
//! The environment variables are the same as in ROS:
//!
//! | variable | values |
//! |---|---|
//! | `ROS_DOMAIN_ID` | 0 (default) to 232 |
//! | `ROS_AUTOMATIC_DISCOVERY_RANGE` | `SUBNET` (default), `SYSTEM_DEFAULT` (same), `LOCALHOST` |
//! | `ROS_LOCALHOST_ONLY` | 0 (default), 1; deprecated, but 1 overrides the range, as in rcl |
//!
//! The range `OFF` and `ROS_STATIC_PEERS` are not supported. [`security`](crate::security)
//! describes the SROS2 variables.

use std::{net::Ipv4Addr, sync::Arc};

use ros_interfaces::Interfaces;
use rustdds::{DomainParticipant, DomainParticipantBuilder};
use thiserror::Error;

#[allow(unused_imports, reason = "the corrected crate has its own method")]
use crate::corrections::Uncorrected;
use crate::{
    escape::escaped,
    security::{EnclaveName, Security, SecurityError},
    types,
};

/// The domain, networks and security of a participant.
///
/// # Examples
///
/// ```
/// use ros_runtime::{
///     discovery::{Discovery, Range},
///     security::EnclaveName,
/// };
///
/// let variables = |name: &str| (name == "ROS_DOMAIN_ID").then(|| "42".to_owned());
/// let discovery = Discovery::from_variables(&EnclaveName::default(), variables)?;
/// assert_eq!((discovery.domain_id, discovery.range), (42, Range::Subnet));
/// # Ok::<(), ros_runtime::discovery::DiscoveryError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Discovery {
    /// The DDS domain, 0 to 232.
    pub domain_id: u16,
    /// The discovery range.
    pub range: Range,
    /// The security configuration of the participant.
    pub security: Security,
}

/// The range in which a participant discovers peers and announces itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// All networks to which this machine is connected.
    Subnet,
    /// This machine only: no packet leaves it.
    Localhost,
}

/// The error returned for an invalid environment variable or if a participant cannot join its
/// domain.
#[derive(Debug, Error, PartialEq)]
pub enum DiscoveryError {
    /// `ROS_DOMAIN_ID` is not a number from 0 to 232.
    #[error("ROS_DOMAIN_ID='{}': expected a number from 0 to 232", escaped(.0))]
    DomainId(String),
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE` is unknown.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE='{}': expected SUBNET, LOCALHOST or SYSTEM_DEFAULT",
        escaped(.0)
    )]
    Range(String),
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE` is `OFF`, which RustDDS does not support.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF is not supported, because the node could not discover \
         its peers: expected SUBNET, LOCALHOST or SYSTEM_DEFAULT"
    )]
    Off,
    /// `ROS_LOCALHOST_ONLY` is neither 0 nor 1.
    #[error("ROS_LOCALHOST_ONLY='{}': expected 0 or 1", escaped(.0))]
    LocalhostOnly(String),
    /// Security is enabled but cannot be used.
    #[error(transparent)]
    Security(#[from] SecurityError),
    /// RustDDS could not create the participant.
    #[error("could not join DDS domain {domain_id}: {}", escaped(.reason))]
    Participant {
        /// The domain.
        domain_id: u16,
        /// The error reported by RustDDS.
        reason: String,
    },
}

impl Discovery {
    /// Reads the environment variables of this process for a participant in `enclave`.
    ///
    /// # Errors
    ///
    /// Same as [`Discovery::from_variables`].
    pub fn from_environment(enclave: &EnclaveName) -> Result<Discovery, DiscoveryError> {
        Discovery::from_variables(enclave, |name| std::env::var(name).ok())
    }

    /// Reads environment variables for a participant in `enclave`.
    ///
    /// `variable` returns the value of a variable; an empty value counts as unset, as in rcl.
    ///
    /// # Errors
    ///
    /// Returns an error if a variable is invalid, or if security is enabled but cannot be used.
    pub fn from_variables(
        enclave: &EnclaveName,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Discovery, DiscoveryError> {
        let security = Security::from_variables(enclave, &variable)?;
        let variable = |name: &str| variable(name).filter(|value| !value.is_empty());
        let domain_id = match variable("ROS_DOMAIN_ID") {
            None => 0,
            // With larger IDs, the RTPS port numbers would exceed 65535.
            Some(text) => match text.parse() {
                Ok(id @ 0..=232) => id,
                _ => return Err(DiscoveryError::DomainId(text)),
            },
        };
        let localhost_only = match variable("ROS_LOCALHOST_ONLY").as_deref() {
            None | Some("0") => false,
            Some("1") => true,
            Some(other) => return Err(DiscoveryError::LocalhostOnly(other.to_owned())),
        };
        let range = match variable("ROS_AUTOMATIC_DISCOVERY_RANGE").as_deref() {
            _ if localhost_only => Range::Localhost,
            None | Some("SUBNET" | "SYSTEM_DEFAULT") => Range::Subnet,
            Some("LOCALHOST") => Range::Localhost,
            Some("OFF") => return Err(DiscoveryError::Off),
            Some(other) => return Err(DiscoveryError::Range(other.to_owned())),
        };
        Ok(Discovery { domain_id, range, security })
    }

    /// Creates a participant, which joins the domain. If RustDDS is the patched copy, the
    /// participant announces the type hashes of `interfaces`.
    ///
    /// # Errors
    ///
    /// Returns an error if the keys cannot be used or if RustDDS fails to start.
    pub fn participant(
        &self,
        interfaces: Arc<Interfaces>,
    ) -> Result<DomainParticipant, DiscoveryError> {
        let builder = DomainParticipantBuilder::new(self.domain_id);
        let builder = builder
            .endpoint_user_data(move |_topic, dds_type| types::user_data(&interfaces, dds_type));
        let builder = match self.range {
            Range::Subnet => builder,
            Range::Localhost => builder.with_only_networks([Ipv4Addr::LOCALHOST]),
        };
        self.security.secure(builder)?.build().map_err(|error| DiscoveryError::Participant {
            domain_id: self.domain_id,
            reason: error.to_string(),
        })
    }
}

/// Logs a warning if `ROS_STATIC_PEERS` is set, because RustDDS discovers peers only by multicast.
pub(crate) fn warn_of_static_peers() {
    let peers = std::env::var("ROS_STATIC_PEERS").unwrap_or_default();
    if !peers.is_empty() {
        log::warn!(
            "ROS_STATIC_PEERS='{}' is ignored: peers are discovered only by multicast",
            escaped(&peers)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn discovery(variables: &[(&str, &str)]) -> Result<Discovery, DiscoveryError> {
        Discovery::from_variables(&EnclaveName::default(), |name| {
            variables.iter().find(|(key, _)| *key == name).map(|(_, value)| value.to_string())
        })
    }

    #[test]
    fn the_defaults_match_ros() {
        let expected = Discovery { domain_id: 0, range: Range::Subnet, security: Security::Off };
        assert_eq!(discovery(&[]), Ok(expected.clone()));
        assert_eq!(discovery(&[("ROS_DOMAIN_ID", "")]), Ok(expected));
    }

    #[test]
    fn reads_the_ros_variables() {
        let localhost =
            Discovery { domain_id: 42, range: Range::Localhost, security: Security::Off };
        let range = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
        assert_eq!(discovery(&[("ROS_DOMAIN_ID", "42"), range]), Ok(localhost.clone()));
        let deprecated = ("ROS_LOCALHOST_ONLY", "1");
        let subnet = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET");
        assert_eq!(discovery(&[("ROS_DOMAIN_ID", "42"), deprecated, subnet]), Ok(localhost));
    }

    #[test]
    fn errors_name_the_variable_and_its_value() {
        for (name, value) in [
            ("ROS_DOMAIN_ID", "233"),
            ("ROS_DOMAIN_ID", "-1"),
            ("ROS_DOMAIN_ID", "one"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "localhost"),
            ("ROS_LOCALHOST_ONLY", "yes"),
        ] {
            let message = discovery(&[(name, value)]).unwrap_err().to_string();
            assert!(message.starts_with(&format!("{name}='{value}': expected")), "{message}");
        }
    }

    #[test]
    fn errors_escape_the_values_that_they_quote() {
        for (name, expected) in [
            ("ROS_DOMAIN_ID", r"ROS_DOMAIN_ID='4\n2': expected a number from 0 to 232"),
            (
                "ROS_AUTOMATIC_DISCOVERY_RANGE",
                "ROS_AUTOMATIC_DISCOVERY_RANGE='4\\n2': expected SUBNET, LOCALHOST or \
                 SYSTEM_DEFAULT",
            ),
            ("ROS_LOCALHOST_ONLY", r"ROS_LOCALHOST_ONLY='4\n2': expected 0 or 1"),
        ] {
            assert_eq!(discovery(&[(name, "4\n2")]).unwrap_err().to_string(), expected);
        }
        let error = DiscoveryError::Participant { domain_id: 42, reason: "a\nb".to_owned() };
        assert_eq!(error.to_string(), r"could not join DDS domain 42: a\nb");
    }
}
