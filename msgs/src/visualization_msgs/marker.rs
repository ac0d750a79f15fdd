use ros2_client::Message;
use serde::{Deserialize, Serialize};

use super::{MeshFile, UVCoordinate};
use crate::{
    Header, RosMessage,
    builtin_interfaces::Duration,
    geometry_msgs::{Point, Pose, Vector3},
    sensor_msgs::CompressedImage,
    std_msgs::ColorRGBA,
};

/// `visualization_msgs/msg/Marker`: a thing that RViz draws, or removes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// When, and the frame of the pose.
    pub header: Header,
    /// The namespace of `id`.
    pub ns: String,
    /// Which marker of its namespace.
    pub id: i32,
    /// What is drawn: one of the kinds below.
    pub r#type: i32,
    /// What to do with it: one of the actions below.
    pub action: i32,
    /// Where it is.
    pub pose: Pose,
    /// Its size in metres, as its kind has it.
    pub scale: Vector3,
    /// Its colour.
    pub color: ColorRGBA,
    /// After this it vanishes; zero: never.
    pub lifetime: Duration,
    /// Whether it moves with its frame after it was sent.
    pub frame_locked: bool,
    /// The points of lists and strips, in the frame of the pose.
    pub points: Vec<Point>,
    /// A colour for each of the points, or none.
    pub colors: Vec<ColorRGBA>,
    /// Where the texture is, or what it is called.
    pub texture_resource: String,
    /// The texture.
    pub texture: CompressedImage,
    /// A place in the texture for each of the points.
    pub uv_coordinates: Vec<UVCoordinate>,
    /// What a text says.
    pub text: String,
    /// Where the mesh is, or what it is called.
    pub mesh_resource: String,
    /// The mesh.
    pub mesh_file: MeshFile,
    /// Whether the mesh has its own colours.
    pub mesh_use_embedded_materials: bool,
}

impl Marker {
    /// A kind: an arrow along x, `scale.x` long.
    pub const ARROW: i32 = 0;
    /// A kind: a box with the sides `scale`.
    pub const CUBE: i32 = 1;
    /// A kind: an ellipsoid with the diameters `scale`.
    pub const SPHERE: i32 = 2;
    /// A kind: a cylinder along z, with the diameters `scale.x` and `scale.y` and the height `scale.z`.
    pub const CYLINDER: i32 = 3;
    /// A kind: one line through all `points`.
    pub const LINE_STRIP: i32 = 4;
    /// A kind: a line for every two `points`.
    pub const LINE_LIST: i32 = 5;
    /// A kind: a box at each of the `points`.
    pub const CUBE_LIST: i32 = 6;
    /// A kind: a sphere at each of the `points`.
    pub const SPHERE_LIST: i32 = 7;
    /// A kind: a square at each of the `points`.
    pub const POINTS: i32 = 8;
    /// A kind: `text` that always faces the viewer.
    pub const TEXT_VIEW_FACING: i32 = 9;
    /// A kind: a mesh.
    pub const MESH_RESOURCE: i32 = 10;
    /// A kind: a triangle for every three `points`.
    pub const TRIANGLE_LIST: i32 = 11;
    /// A kind: an arrow between any two `points` that follow each other.
    pub const ARROW_STRIP: i32 = 12;
    /// An action: draw the marker, in the place of an earlier one of the same `ns` and `id`.
    pub const ADD: i32 = 0;
    /// Another name of [`Marker::ADD`].
    pub const MODIFY: i32 = 0;
    /// An action: remove the marker with this `ns` and `id`.
    pub const DELETE: i32 = 2;
    /// An action: remove every marker.
    pub const DELETEALL: i32 = 3;
}

impl Message for Marker {}

impl RosMessage for Marker {
    const PACKAGE: &str = super::PACKAGE;
    const NAME: &str = "Marker";
}
