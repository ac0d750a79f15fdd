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

    /// The name of the type as [`TypeDescription::of`] takes it, such as `sensor_msgs/msg/Image`.
    ///
    /// [`TypeDescription::of`]: crate::type_description_interfaces::TypeDescription::of
    fn full_name() -> String {
        format!("{}/msg/{}", Self::PACKAGE, Self::NAME)
    }
}

/// A service: the pair of a request and a response, with the name that ROS 2 knows the pair by.
///
/// It is implemented by a marker, such as [`Reset`](crate::Reset) or [`Step`](crate::Step), that is
/// never made.
pub trait RosService {
    /// The ROS package of the definition.
    const PACKAGE: &str;
    /// The name of the definition in that package, such as `Step`.
    const NAME: &str;
    /// What a client asks.
    type Request: Message + Clone + Send + Sync + 'static;
    /// What the server answers.
    type Response: Message + Clone + Send + Sync + 'static;

    /// The name of the type as ros2-client's clients and servers take it.
    fn type_name() -> ServiceTypeName {
        ServiceTypeName::new(Self::PACKAGE, Self::NAME)
    }

    /// The name of the type as [`TypeDescription::of`] takes it, such as `evac_msgs/srv/Step`.
    ///
    /// [`TypeDescription::of`]: crate::type_description_interfaces::TypeDescription::of
    fn full_name() -> String {
        format!("{}/srv/{}", Self::PACKAGE, Self::NAME)
    }
}
