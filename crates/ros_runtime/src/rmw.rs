//! Which middleware the other nodes run on, as `RMW_IMPLEMENTATION` says.
//!
//! Topics are the same on all of them. Services are not: Fast DDS sends the number of a request beside
//! the data, CycloneDDS before it.

use ros2_client::ServiceMapping;
use thiserror::Error;

/// A middleware that ROS 2 nodes run on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rmw {
    /// Fast DDS, ROS 2's default.
    #[default]
    FastDds,
    /// CycloneDDS.
    CycloneDds,
}

/// A middleware that cannot be spoken with.
#[derive(Debug, Error, PartialEq)]
#[error(
    "RMW_IMPLEMENTATION='{0}': expected rmw_fastrtps_cpp, rmw_fastrtps_dynamic_cpp or \
     rmw_cyclonedds_cpp"
)]
pub struct UnknownRmw(String);

impl Rmw {
    /// Reads the process's environment.
    pub fn from_environment() -> Result<Rmw, UnknownRmw> {
        Rmw::from_name(&std::env::var("RMW_IMPLEMENTATION").unwrap_or_default())
    }

    /// The middleware of that name; nothing is the default.
    pub fn from_name(name: &str) -> Result<Rmw, UnknownRmw> {
        match name {
            "" | "rmw_fastrtps_cpp" | "rmw_fastrtps_dynamic_cpp" => Ok(Rmw::FastDds),
            "rmw_cyclonedds_cpp" => Ok(Rmw::CycloneDds),
            other => Err(UnknownRmw(other.to_owned())),
        }
    }

    /// How it maps services to DDS.
    pub(crate) fn service_mapping(self) -> ServiceMapping {
        match self {
            Rmw::FastDds => ServiceMapping::Enhanced,
            Rmw::CycloneDds => ServiceMapping::Cyclone,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_ros() {
        assert_eq!(Rmw::from_name(""), Ok(Rmw::FastDds));
        assert_eq!(Rmw::from_name("rmw_cyclonedds_cpp"), Ok(Rmw::CycloneDds));
        let message = Rmw::from_name("rmw_zenoh_cpp").unwrap_err().to_string();
        assert!(message.starts_with("RMW_IMPLEMENTATION='rmw_zenoh_cpp': expected"), "{message}");
    }
}
