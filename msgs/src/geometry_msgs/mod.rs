//! Messages of the ROS package `geometry_msgs`.

mod point;
mod pose;
mod pose_stamped;
mod pose_with_covariance;
mod quaternion;
mod transform;
mod transform_stamped;
mod twist;
mod twist_with_covariance;
mod vector3;

pub use point::Point;
pub use pose::Pose;
pub use pose_stamped::PoseStamped;
pub use pose_with_covariance::PoseWithCovariance;
pub use quaternion::Quaternion;
pub use transform::Transform;
pub use transform_stamped::TransformStamped;
pub use twist::Twist;
pub use twist_with_covariance::TwistWithCovariance;
pub use vector3::Vector3;

/// The name of the ROS package.
const PACKAGE: &str = "geometry_msgs";
