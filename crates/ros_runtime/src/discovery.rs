//! Which DDS domain a node joins, on which networks, and with which keys.
//!
//! The variables are ROS's: `ROS_DOMAIN_ID` (0 to 232), `ROS_AUTOMATIC_DISCOVERY_RANGE` (`SUBNET`,
//! `LOCALHOST`, `OFF`, `SYSTEM_DEFAULT`) and its deprecated predecessor `ROS_LOCALHOST_ONLY`, which
//! wins where it is set to 1, as in rcl; [`security`](crate::security) has those for the keys.

use std::{net::Ipv4Addr, sync::Arc};

use ros_interfaces::Interfaces;
use rustdds::{DomainParticipant, DomainParticipantBuilder};
use thiserror::Error;

#[allow(unused_imports, reason = "the corrected crate has a method of its own")]
use crate::corrections::Uncorrected;
use crate::{
    security::{EnclaveName, Security, SecurityError},
    types,
};

/// What the environment says about discovery.
#[derive(Clone, Debug, PartialEq)]
pub struct Discovery {
    /// The DDS domain.
    pub domain_id: u16,
    /// How far to look for others.
    pub range: Range,
    /// Whose keys the participant has.
    pub security: Security,
}

/// How far a participant looks for others and announces itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Every network of this machine.
    Subnet,
    /// This machine only: no packet leaves it.
    Localhost,
}

/// Why the environment cannot be followed.
#[derive(Debug, Error, PartialEq)]
pub enum DiscoveryError {
    /// A domain that does not exist.
    #[error("ROS_DOMAIN_ID='{0}': expected a number from 0 to 232")]
    DomainId(String),
    /// A range that ROS does not have.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE='{0}': expected SUBNET, LOCALHOST, OFF or SYSTEM_DEFAULT"
    )]
    Range(String),
    /// A range that RustDDS does not have.
    #[error(
        "ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: a node that finds nobody could not reach its peer; \
         use LOCALHOST to stay on this machine"
    )]
    Off,
    /// A switch that is neither on nor off.
    #[error("ROS_LOCALHOST_ONLY='{0}': expected 0 or 1")]
    LocalhostOnly(String),
    /// The participant cannot be as secure as it should.
    #[error(transparent)]
    Security(#[from] SecurityError),
    /// DDS did not start.
    #[error("could not join DDS domain {domain_id}: {reason}")]
    Participant {
        /// The domain.
        domain_id: u16,
        /// What RustDDS says.
        reason: String,
    },
}

impl Discovery {
    /// Reads the process's environment for a participant in this enclave.
    pub fn from_environment(enclave: &EnclaveName) -> Result<Discovery, DiscoveryError> {
        Discovery::from_variables(enclave, |name| std::env::var(name).ok())
    }

    /// Reads the variables through a function; an empty one counts as not set, as in rcl.
    pub fn from_variables(
        enclave: &EnclaveName,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Discovery, DiscoveryError> {
        let security = Security::from_variables(enclave, &variable)?;
        let variable = |name: &str| variable(name).filter(|value| !value.is_empty());
        let domain_id = match variable("ROS_DOMAIN_ID") {
            None => 0,
            // Above 232 the ports of RTPS's formula pass 65535.
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

    /// Joins the domain.
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

/// Says once what cannot be followed: RustDDS finds others by multicast only.
pub(crate) fn warn_of_static_peers() {
    let peers = std::env::var("ROS_STATIC_PEERS").unwrap_or_default();
    if !peers.is_empty() {
        log::warn!(
            "ROS_STATIC_PEERS='{peers}' is not followed: others are found by multicast only"
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
    fn defaults_are_those_of_ros() {
        let expected = Discovery { domain_id: 0, range: Range::Subnet, security: Security::Off };
        assert_eq!(discovery(&[]), Ok(expected.clone()));
        assert_eq!(discovery(&[("ROS_DOMAIN_ID", "")]), Ok(expected));
    }

    #[test]
    fn variables_are_followed() {
        let localhost =
            Discovery { domain_id: 42, range: Range::Localhost, security: Security::Off };
        let range = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
        assert_eq!(discovery(&[("ROS_DOMAIN_ID", "42"), range]), Ok(localhost.clone()));
        let old = ("ROS_LOCALHOST_ONLY", "1");
        let subnet = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET");
        assert_eq!(discovery(&[("ROS_DOMAIN_ID", "42"), old, subnet]), Ok(localhost));
    }

    #[test]
    fn bad_values_are_named() {
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
}
