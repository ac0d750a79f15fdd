use ros2_client::{Message, MessageTypeName, ServiceTypeName};

/// A message that a topic can carry, with the name that ROS 2 knows its type by.
pub trait RosMessage: Message + Clone + Send + Sync + 'static {
    /// The ROS package of the definition, such as `sensor_msgs`.
    const PACKAGE: &str;
    /// The name of the definition in that package, such as `Image`.
    const NAME: &str;

    /// The name of the type as ros2-client's topics take it.
    fn type_name() -> MessageTypeName {
        MessageTypeName::new(Self::PACKAGE, Self::NAME)
    }

    /// The full name of the type, such as `sensor_msgs/msg/Image`.
    fn full_name() -> String {
        format!("{}/msg/{}", Self::PACKAGE, Self::NAME)
    }
}

/// A service: the pair of a request and a response, with the name that ROS 2 knows the pair by.
///
/// It is implemented by a marker that is never made, such as
/// [`GetParameters`](crate::rcl_interfaces::GetParameters).
pub trait RosService {
    /// The ROS package of the definition.
    const PACKAGE: &str;
    /// The name of the definition in that package, such as `GetParameters`.
    const NAME: &str;
    /// What a client asks.
    type Request: Message + Clone + Send + Sync + 'static;
    /// What the server answers.
    type Response: Message + Clone + Send + Sync + 'static;

    /// The name of the type as ros2-client's clients and servers take it.
    fn type_name() -> ServiceTypeName {
        ServiceTypeName::new(Self::PACKAGE, Self::NAME)
    }

    /// The full name of the type, such as `rcl_interfaces/srv/GetParameters`.
    fn full_name() -> String {
        format!("{}/srv/{}", Self::PACKAGE, Self::NAME)
    }
}
