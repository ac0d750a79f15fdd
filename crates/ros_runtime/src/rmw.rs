//! The middleware that the peers use, from `RMW_IMPLEMENTATION`.
//!
//! Topics work the same way with all DDS implementations, but services do not: Fast DDS sends the
//! sequence number of a request as metadata, and CycloneDDS sends it at the beginning of the
//! payload.

use ros2_client::ServiceMapping;
use thiserror::Error;

use crate::escape::escaped;

/// A DDS implementation of ROS 2.
///
/// # Examples
///
/// ```
/// use ros_runtime::rmw::Rmw;
///
/// assert_eq!(Rmw::from_name("")?, Rmw::FastDds);
/// assert_eq!(Rmw::from_name("rmw_cyclonedds_cpp")?, Rmw::CycloneDds);
/// # Ok::<(), ros_runtime::rmw::UnknownRmw>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rmw {
    /// Fast DDS, the default of ROS 2.
    #[default]
    FastDds,
    /// CycloneDDS.
    CycloneDds,
}

/// The error returned for an unsupported middleware.
#[derive(Debug, Error, PartialEq)]
#[error(
    "RMW_IMPLEMENTATION='{}': expected rmw_fastrtps_cpp, rmw_fastrtps_dynamic_cpp or \
     rmw_cyclonedds_cpp",
    escaped(.0)
)]
pub struct UnknownRmw(String);

impl Rmw {
    /// Reads `RMW_IMPLEMENTATION` from the environment of this process.
    ///
    /// # Errors
    ///
    /// Same as [`Rmw::from_name`].
    pub fn from_environment() -> Result<Rmw, UnknownRmw> {
        Rmw::from_name(&std::env::var("RMW_IMPLEMENTATION").unwrap_or_default())
    }

    /// Returns the middleware with a name, as in `RMW_IMPLEMENTATION`. An empty name selects the
    /// default.
    ///
    /// # Errors
    ///
    /// Returns an error if the name is unknown or the middleware is not supported.
    pub fn from_name(name: &str) -> Result<Rmw, UnknownRmw> {
        match name {
            "" | "rmw_fastrtps_cpp" | "rmw_fastrtps_dynamic_cpp" => Ok(Rmw::FastDds),
            "rmw_cyclonedds_cpp" => Ok(Rmw::CycloneDds),
            other => Err(UnknownRmw(other.to_owned())),
        }
    }

    /// Returns the middleware's mapping from services to DDS.
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
    fn recognizes_the_ros_names() {
        assert_eq!(Rmw::from_name(""), Ok(Rmw::FastDds));
        assert_eq!(Rmw::from_name("rmw_cyclonedds_cpp"), Ok(Rmw::CycloneDds));
        let message = Rmw::from_name("rmw\nzenoh").unwrap_err().to_string();
        let expected = "RMW_IMPLEMENTATION='rmw\\nzenoh': expected rmw_fastrtps_cpp, \
                        rmw_fastrtps_dynamic_cpp or rmw_cyclonedds_cpp";
        assert_eq!(message, expected);
    }
}
