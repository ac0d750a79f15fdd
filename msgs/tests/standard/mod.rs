//! The standard definitions that the package and the nodes use, as ROS 2 Jazzy has them (the
//! packages common_interfaces, geometry2 and rcl_interfaces), without comments and default values.
//! ROS 2 installs them, so no file of them is here.

/// The full name of each, with its constants and fields.
pub const DEFINITIONS: [(&str, &str); 29] = [
    (
        "builtin_interfaces/Duration",
        "int32 sec
         uint32 nanosec",
    ),
    (
        "builtin_interfaces/Time",
        "int32 sec
         uint32 nanosec",
    ),
    (
        "diagnostic_msgs/DiagnosticArray",
        "std_msgs/Header header
         diagnostic_msgs/DiagnosticStatus[] status",
    ),
    (
        "diagnostic_msgs/DiagnosticStatus",
        "byte OK=0
         byte WARN=1
         byte ERROR=2
         byte STALE=3
         byte level
         string name
         string message
         string hardware_id
         diagnostic_msgs/KeyValue[] values",
    ),
    (
        "diagnostic_msgs/KeyValue",
        "string key
         string value",
    ),
    (
        "geometry_msgs/Point",
        "float64 x
         float64 y
         float64 z",
    ),
    (
        "geometry_msgs/Pose",
        "geometry_msgs/Point position
         geometry_msgs/Quaternion orientation",
    ),
    (
        "geometry_msgs/PoseStamped",
        "std_msgs/Header header
         geometry_msgs/Pose pose",
    ),
    (
        "geometry_msgs/PoseWithCovariance",
        "geometry_msgs/Pose pose
         float64[36] covariance",
    ),
    (
        "geometry_msgs/Quaternion",
        "float64 x
         float64 y
         float64 z
         float64 w",
    ),
    (
        "geometry_msgs/Transform",
        "geometry_msgs/Vector3 translation
         geometry_msgs/Quaternion rotation",
    ),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header
         string child_frame_id
         geometry_msgs/Transform transform",
    ),
    (
        "geometry_msgs/Twist",
        "geometry_msgs/Vector3 linear
         geometry_msgs/Vector3 angular",
    ),
    (
        "geometry_msgs/TwistWithCovariance",
        "geometry_msgs/Twist twist
         float64[36] covariance",
    ),
    (
        "geometry_msgs/Vector3",
        "float64 x
         float64 y
         float64 z",
    ),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header
         string child_frame_id
         geometry_msgs/PoseWithCovariance pose
         geometry_msgs/TwistWithCovariance twist",
    ),
    (
        "nav_msgs/Path",
        "std_msgs/Header header
         geometry_msgs/PoseStamped[] poses",
    ),
    ("rosgraph_msgs/Clock", "builtin_interfaces/Time clock"),
    (
        "sensor_msgs/CameraInfo",
        "std_msgs/Header header
         uint32 height
         uint32 width
         string distortion_model
         float64[] d
         float64[9] k
         float64[9] r
         float64[12] p
         uint32 binning_x
         uint32 binning_y
         sensor_msgs/RegionOfInterest roi",
    ),
    (
        "sensor_msgs/CompressedImage",
        "std_msgs/Header header
         string format
         uint8[] data",
    ),
    (
        "sensor_msgs/Image",
        "std_msgs/Header header
         uint32 height
         uint32 width
         string encoding
         uint8 is_bigendian
         uint32 step
         uint8[] data",
    ),
    (
        "sensor_msgs/RegionOfInterest",
        "uint32 x_offset
         uint32 y_offset
         uint32 height
         uint32 width
         bool do_rectify",
    ),
    (
        "std_msgs/ColorRGBA",
        "float32 r
         float32 g
         float32 b
         float32 a",
    ),
    (
        "std_msgs/Header",
        "builtin_interfaces/Time stamp
         string frame_id",
    ),
    ("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms"),
    (
        "visualization_msgs/Marker",
        "int32 ARROW=0
         int32 CUBE=1
         int32 SPHERE=2
         int32 CYLINDER=3
         int32 LINE_STRIP=4
         int32 LINE_LIST=5
         int32 CUBE_LIST=6
         int32 SPHERE_LIST=7
         int32 POINTS=8
         int32 TEXT_VIEW_FACING=9
         int32 MESH_RESOURCE=10
         int32 TRIANGLE_LIST=11
         int32 ARROW_STRIP=12
         int32 ADD=0
         int32 MODIFY=0
         int32 DELETE=2
         int32 DELETEALL=3
         std_msgs/Header header
         string ns
         int32 id
         int32 type
         int32 action
         geometry_msgs/Pose pose
         geometry_msgs/Vector3 scale
         std_msgs/ColorRGBA color
         builtin_interfaces/Duration lifetime
         bool frame_locked
         geometry_msgs/Point[] points
         std_msgs/ColorRGBA[] colors
         string texture_resource
         sensor_msgs/CompressedImage texture
         visualization_msgs/UVCoordinate[] uv_coordinates
         string text
         string mesh_resource
         visualization_msgs/MeshFile mesh_file
         bool mesh_use_embedded_materials",
    ),
    ("visualization_msgs/MarkerArray", "visualization_msgs/Marker[] markers"),
    (
        "visualization_msgs/MeshFile",
        "string filename
         uint8[] data",
    ),
    (
        "visualization_msgs/UVCoordinate",
        "float32 u
         float32 v",
    ),
];
