//! Messages of the ROS package `visualization_msgs`.

mod marker;
mod marker_array;
mod mesh_file;
mod uv_coordinate;

pub use marker::Marker;
pub use marker_array::MarkerArray;
pub use mesh_file::MeshFile;
pub use uv_coordinate::UVCoordinate;

/// The name of the ROS package.
const PACKAGE: &str = "visualization_msgs";
