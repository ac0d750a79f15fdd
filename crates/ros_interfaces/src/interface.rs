use ros2_client::{Message, MessageTypeName, ServiceTypeName};

/// A message type for topics, with its ROS name.
///
/// # Examples
///
/// ```
/// use ros_interfaces::{RosMessage, sensor_msgs::Image};
///
/// assert_eq!((Image::PACKAGE, Image::NAME), ("sensor_msgs", "Image"));
/// assert_eq!(Image::full_name(), "sensor_msgs/msg/Image");
/// ```
pub trait RosMessage: Message + Clone + Send + Sync + 'static {
    /// The ROS package that contains the definition, e.g. `sensor_msgs`.
    const PACKAGE: &str;
    /// The name of the definition in that package, e.g. `Image`.
    const NAME: &str;

    /// Returns the type name in the form that ros2-client expects for topics.
    fn type_name() -> MessageTypeName {
        MessageTypeName::new(Self::PACKAGE, Self::NAME)
    }

    /// Returns the full name of the type, e.g. `sensor_msgs/msg/Image`.
    fn full_name() -> String {
        format!("{}/msg/{}", Self::PACKAGE, Self::NAME)
    }
}

/// A service type: its request, its response and its ROS name.
///
/// Implemented by empty marker types, e.g. [`GetParameters`](crate::rcl_interfaces::GetParameters).
///
/// # Examples
///
/// ```
/// use ros_interfaces::{
///     RosService,
///     rcl_interfaces::{GetParameters, get_parameters},
/// };
///
/// let request: <GetParameters as RosService>::Request =
///     get_parameters::Request { names: vec!["seed".to_owned()] };
/// assert_eq!(request.names, ["seed"]);
/// assert_eq!(GetParameters::full_name(), "rcl_interfaces/srv/GetParameters");
/// ```
pub trait RosService {
    /// The ROS package that contains the definition, e.g. `rcl_interfaces`.
    const PACKAGE: &str;
    /// The name of the definition in that package, e.g. `GetParameters`.
    const NAME: &str;
    /// The type of the request.
    type Request: Message + Clone + Send + Sync + 'static;
    /// The type of the response.
    type Response: Message + Clone + Send + Sync + 'static;

    /// Returns the type name in the form that ros2-client expects for clients and servers.
    fn type_name() -> ServiceTypeName {
        ServiceTypeName::new(Self::PACKAGE, Self::NAME)
    }

    /// Returns the full name of the type, e.g. `rcl_interfaces/srv/GetParameters`.
    fn full_name() -> String {
        format!("{}/srv/{}", Self::PACKAGE, Self::NAME)
    }
}
