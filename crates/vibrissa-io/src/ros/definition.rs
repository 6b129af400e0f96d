//! The definitions of the messages (ros2msg): the fields of a message, then those of every message inside it.

/// A kind of ROS 2 message that is read or written here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `nav_msgs/msg/Odometry`.
    Odometry,
    /// `geometry_msgs/msg/WrenchStamped`.
    Wrench,
    /// `sensor_msgs/msg/MagneticField`.
    Field,
    /// `sensor_msgs/msg/Imu`.
    Imu,
    /// `geometry_msgs/msg/PoseWithCovarianceStamped`.
    PoseWithCovariance,
    /// `geometry_msgs/msg/PoseStamped`.
    Pose,
    /// `nav_msgs/msg/Path`.
    Path,
    /// `nav_msgs/msg/OccupancyGrid`.
    Grid,
    /// `visualization_msgs/msg/MarkerArray`.
    Markers,
    /// `sensor_msgs/msg/PointCloud2`.
    Cloud,
    /// `sensor_msgs/msg/JointState`.
    Joints,
    /// `std_msgs/msg/String`.
    Text,
    /// `std_msgs/msg/UInt8MultiArray`.
    Bytes,
}

const HEADER: &str = "std_msgs/Header header\n";
const HEADER_PARTS: &[(&str, &str)] = &[
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
];
const VECTOR: (&str, &str) = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n");
const QUATERNION: (&str, &str) = ("geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n");
const POSE: &[(&str, &str)] = &[
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    POINT,
    QUATERNION,
];
const POINT: (&str, &str) = ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n");
const POSE_COVARIANCE: (&str, &str) =
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n");

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 13] = [
        Self::Odometry,
        Self::Wrench,
        Self::Field,
        Self::Imu,
        Self::PoseWithCovariance,
        Self::Pose,
        Self::Path,
        Self::Grid,
        Self::Markers,
        Self::Cloud,
        Self::Joints,
        Self::Text,
        Self::Bytes,
    ];

    /// The full name, `package/msg/Name`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Odometry => "nav_msgs/msg/Odometry",
            Self::Wrench => "geometry_msgs/msg/WrenchStamped",
            Self::Field => "sensor_msgs/msg/MagneticField",
            Self::Imu => "sensor_msgs/msg/Imu",
            Self::PoseWithCovariance => "geometry_msgs/msg/PoseWithCovarianceStamped",
            Self::Pose => "geometry_msgs/msg/PoseStamped",
            Self::Path => "nav_msgs/msg/Path",
            Self::Grid => "nav_msgs/msg/OccupancyGrid",
            Self::Markers => "visualization_msgs/msg/MarkerArray",
            Self::Cloud => "sensor_msgs/msg/PointCloud2",
            Self::Joints => "sensor_msgs/msg/JointState",
            Self::Text => "std_msgs/msg/String",
            Self::Bytes => "std_msgs/msg/UInt8MultiArray",
        }
    }

    /// The kind of this name, written with or without its middle part `msg`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let (package, word) = (name.split('/').next()?, name.rsplit('/').next()?);
        let matches = |kind: &Self| {
            let known = kind.name();
            known.strip_prefix(package).and_then(|rest| rest.strip_prefix("/msg/")) == Some(word)
        };
        Self::ALL.into_iter().find(matches)
    }

    /// The definition (`ros2msg`) with every message inside it.
    #[must_use]
    pub fn definition(self) -> String {
        let (fields, parts): (&str, Vec<&[(&str, &str)]>) = match self {
            Self::Odometry => (
                "string child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
                 geometry_msgs/TwistWithCovariance twist\n",
                vec![
                    &[POSE_COVARIANCE],
                    POSE,
                    &[
                        ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"),
                        ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"),
                        VECTOR,
                    ],
                ],
            ),
            Self::Wrench => (
                "geometry_msgs/Wrench wrench\n",
                vec![&[
                    ("geometry_msgs/Wrench", "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n"),
                    VECTOR,
                ]],
            ),
            Self::Field => {
                ("geometry_msgs/Vector3 magnetic_field\nfloat64[9] magnetic_field_covariance\n", vec![&[VECTOR]])
            }
            Self::Imu => (
                "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
                 geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
                 geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
                vec![&[QUATERNION, VECTOR]],
            ),
            Self::PoseWithCovariance => ("geometry_msgs/PoseWithCovariance pose\n", vec![&[POSE_COVARIANCE], POSE]),
            Self::Pose => ("geometry_msgs/Pose pose\n", vec![POSE]),
            Self::Path => (
                "geometry_msgs/PoseStamped[] poses\n",
                vec![&[("geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n")], POSE],
            ),
            Self::Grid => (
                "nav_msgs/MapMetaData info\nint8[] data\n",
                vec![
                    &[(
                        "nav_msgs/MapMetaData",
                        "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n\
                         geometry_msgs/Pose origin\n",
                    )],
                    POSE,
                ],
            ),
            Self::Markers => ("", vec![MARKER, POSE, &[VECTOR]]),
            Self::Cloud => (
                "uint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\n\
                 uint32 row_step\nuint8[] data\nbool is_dense\n",
                vec![&[("sensor_msgs/PointField", "string name\nuint32 offset\nuint8 datatype\nuint32 count\n")]],
            ),
            Self::Joints => ("string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n", Vec::new()),
            Self::Text => return "string data\n".to_owned(),
            Self::Bytes => (
                "",
                vec![&[
                    ("std_msgs/MultiArrayLayout", "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n"),
                    ("std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride\n"),
                ]],
            ),
        };
        let mut text = match self {
            Self::Markers => "visualization_msgs/Marker[] markers\n".to_owned(),
            Self::Bytes => "std_msgs/MultiArrayLayout layout\nuint8[] data\n".to_owned(),
            _ => format!("{HEADER}{fields}"),
        };
        let header = if self == Self::Bytes { &[][..] } else { HEADER_PARTS };
        for (name, fields) in parts.into_iter().chain([header]).flatten() {
            text.push_str(&"=".repeat(80));
            text.push_str(&format!("\nMSG: {name}\n{fields}"));
        }
        text
    }
}

const MARKER: &[(&str, &str)] = &[
    (
        "visualization_msgs/Marker",
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n\
         geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n\
         bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n\
         sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n\
         string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n",
    ),
    ("std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"),
    ("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
    ("visualization_msgs/MeshFile", "string filename\nuint8[] data\n"),
];

#[cfg(test)]
mod tests {
    use super::Kind;

    #[test]
    fn every_definition_carries_every_message_inside_it_once() {
        for kind in Kind::ALL {
            let text = kind.definition();
            let defined: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
            for line in text.lines().filter(|line| !line.starts_with(['=', 'M'])) {
                let word = line.split([' ', '[']).next().unwrap_or_default();
                let times = defined.iter().filter(|name| **name == word).count();
                assert!(!word.contains('/') || times == 1, "{kind:?}: {word} is defined {times} times");
            }
            assert_eq!(Kind::from_name(kind.name()), Some(kind));
            assert_eq!(Kind::from_name(&kind.name().replace("/msg/", "/")), Some(kind));
        }
        assert_eq!(Kind::from_name("nav_msgs/msg/Odo"), None);
        assert_eq!(Kind::from_name("std_msgs/msg/Odometry"), None);
    }
}
