//! Common messages of ROS 2, which ports can have instead of messages of their own types.

use dotgen_syntax::suggestion::advice;

use crate::description::{Base, Count, Field, FieldType, Types};

/// Messages, with their fields as in `.msg` files, and their defaults.
const COMMON: &[(&str, &[&str])] = &[
    ("builtin_interfaces/msg/Time", &["int32 sec", "uint32 nanosec"]),
    ("std_msgs/msg/Header", &["builtin_interfaces/Time stamp", "string frame_id"]),
    ("geometry_msgs/msg/Point", &["float64 x", "float64 y", "float64 z"]),
    ("geometry_msgs/msg/Quaternion", &["float64 x", "float64 y", "float64 z", "float64 w 1"]),
    ("geometry_msgs/msg/Vector3", &["float64 x", "float64 y", "float64 z"]),
    (
        "geometry_msgs/msg/Pose",
        &["geometry_msgs/Point position", "geometry_msgs/Quaternion orientation"],
    ),
    ("geometry_msgs/msg/PoseStamped", &["std_msgs/Header header", "geometry_msgs/Pose pose"]),
    (
        "geometry_msgs/msg/PoseWithCovariance",
        &["geometry_msgs/Pose pose", "float64[36] covariance"],
    ),
    ("geometry_msgs/msg/Twist", &["geometry_msgs/Vector3 linear", "geometry_msgs/Vector3 angular"]),
    ("geometry_msgs/msg/TwistStamped", &["std_msgs/Header header", "geometry_msgs/Twist twist"]),
    (
        "geometry_msgs/msg/TwistWithCovariance",
        &["geometry_msgs/Twist twist", "float64[36] covariance"],
    ),
    (
        "nav_msgs/msg/Odometry",
        &[
            "std_msgs/Header header",
            "string child_frame_id",
            "geometry_msgs/PoseWithCovariance pose",
            "geometry_msgs/TwistWithCovariance twist",
        ],
    ),
    (
        "sensor_msgs/msg/Imu",
        &[
            "std_msgs/Header header",
            "geometry_msgs/Quaternion orientation",
            "float64[9] orientation_covariance",
            "geometry_msgs/Vector3 angular_velocity",
            "float64[9] angular_velocity_covariance",
            "geometry_msgs/Vector3 linear_acceleration",
            "float64[9] linear_acceleration_covariance",
        ],
    ),
    (
        "sensor_msgs/msg/Image",
        &[
            "std_msgs/Header header",
            "uint32 height",
            "uint32 width",
            "string encoding",
            "uint8 is_bigendian",
            "uint32 step",
            "uint8[] data",
        ],
    ),
    (
        "sensor_msgs/msg/RegionOfInterest",
        &["uint32 x_offset", "uint32 y_offset", "uint32 height", "uint32 width", "bool do_rectify"],
    ),
    (
        "sensor_msgs/msg/CameraInfo",
        &[
            "std_msgs/Header header",
            "uint32 height",
            "uint32 width",
            "string distortion_model",
            "float64[] d",
            "float64[9] k",
            "float64[9] r",
            "float64[12] p",
            "uint32 binning_x",
            "uint32 binning_y",
            "sensor_msgs/RegionOfInterest roi",
        ],
    ),
    (
        "sensor_msgs/msg/LaserScan",
        &[
            "std_msgs/Header header",
            "float32 angle_min",
            "float32 angle_max",
            "float32 angle_increment",
            "float32 time_increment",
            "float32 scan_time",
            "float32 range_min",
            "float32 range_max",
            "float32[] ranges",
            "float32[] intensities",
        ],
    ),
    (
        "sensor_msgs/msg/PointField",
        &["string name", "uint32 offset", "uint8 datatype", "uint32 count"],
    ),
    (
        "sensor_msgs/msg/PointCloud2",
        &[
            "std_msgs/Header header",
            "uint32 height",
            "uint32 width",
            "sensor_msgs/PointField[] fields",
            "bool is_bigendian",
            "uint32 point_step",
            "uint32 row_step",
            "uint8[] data",
            "bool is_dense",
        ],
    ),
    (
        "sensor_msgs/msg/JointState",
        &[
            "std_msgs/Header header",
            "string[] name",
            "float64[] position",
            "float64[] velocity",
            "float64[] effort",
        ],
    ),
];

/// Nanoseconds of a second.
pub(crate) const SECOND: u32 = 1_000_000_000;

/// A number, a string or a list of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Leaf {
    /// The path within the message: `pose.covariance[3]`, `fields[].name` within an element of a list.
    pub(crate) path: String,
    /// The type: a number or a string, or the type of each element of a list.
    pub(crate) base: Base,
    /// The leaves of an element of a list.
    pub(crate) elements: Option<Vec<Leaf>>,
    /// The value if nothing is assigned.
    pub(crate) default: i32,
    /// True for the parts of a moment.
    pub(crate) is_time: bool,
}

impl Leaf {
    /// The path within an element of a list: `name`, empty if the element is the leaf.
    pub(crate) fn within_element(&self) -> &str {
        let rest = self.path.rsplit_once("[]").map_or(self.path.as_str(), |(_, rest)| rest);
        rest.trim_start_matches('.')
    }
}

/// The names of all common messages: `geometry_msgs/msg/Pose`.
pub fn names() -> impl Iterator<Item = &'static str> {
    COMMON.iter().map(|common| common.0)
}

/// The full name of a common message: `geometry_msgs/msg/Pose` for `geometry_msgs/Pose`.
///
/// # Errors
/// The name is not that of a common message.
pub(crate) fn full_name(name: &str) -> Result<String, String> {
    let short = name.replacen("/msg/", "/", 1);
    let full = short.replacen('/', "/msg/", 1);
    if names().any(|name| name == full) {
        return Ok(full);
    }
    let known: Vec<String> = names().map(|name| name.replacen("/msg/", "/", 1)).collect();
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    Err(format!("`{short}` is not a known message; {}", advice(&short, &known)))
}

/// Adds a common message, and those that it refers to.
pub fn add(name: &str, types: &mut Types) {
    let fields: Vec<Field> = fields(name).map(|(field, _)| field).collect();
    for field in &fields {
        if let Base::Nested(name) = &field.ty.base {
            add(name, types);
        }
    }
    types.add(name, fields);
}

/// The leaves of a common message, in the order of its payload.
pub(crate) fn leaves(name: &str) -> Vec<Leaf> {
    let mut out = Vec::new();
    add_leaves(name, "", &mut out);
    out
}

fn add_leaves(name: &str, within: &str, out: &mut Vec<Leaf>) {
    for (field, default) in fields(name) {
        let path = format!("{within}{}", field.name);
        let is_time = name == crate::description::TIME;
        let leaf =
            |path| Leaf { path, base: field.ty.base.clone(), elements: None, default, is_time };
        match (field.ty.count, &field.ty.base) {
            (Count::One, Base::Nested(name)) => add_leaves(name, &format!("{path}."), out),
            (Count::Exactly(number), _) => {
                out.extend((0..number).map(|at| leaf(format!("{path}[{at}]"))));
            }
            (Count::Any, base) => {
                let mut elements = Vec::new();
                match base {
                    Base::Nested(name) => add_leaves(name, &format!("{path}[]."), &mut elements),
                    _ => elements.push(leaf(format!("{path}[]"))),
                }
                out.push(Leaf { elements: Some(elements), ..leaf(path) });
            }
            _ => out.push(leaf(path)),
        }
    }
}

/// The fields of a common message, with their defaults.
pub(crate) fn fields(name: &str) -> impl Iterator<Item = (Field, i32)> {
    let found = COMMON.iter().find(|common| common.0 == name);
    found.into_iter().flat_map(|common| common.1).map(|text| {
        let mut words = text.split(' ');
        let ty = words.next().unwrap_or_default();
        let field = Field::new(words.next().unwrap_or_default(), field_type(ty));
        let default = words.next().and_then(|word| word.parse().ok());
        (field, default.unwrap_or(0))
    })
}

fn field_type(text: &str) -> FieldType {
    let (base, length) = text
        .split_once('[')
        .map_or((text, None), |(base, rest)| (base, Some(rest.trim_end_matches(']').parse())));
    let base = match base {
        "bool" => Base::Bool,
        "uint8" => Base::Uint8,
        "int32" => Base::Int32,
        "uint32" => Base::Uint32,
        "float32" => Base::Float32,
        "float64" => Base::Float64,
        "string" => Base::String,
        nested => Base::Nested(nested.replacen('/', "/msg/", 1)),
    };
    let count = match length {
        None => Count::One,
        Some(Ok(number)) => Count::Exactly(number),
        Some(Err(_)) => Count::Any,
    };
    FieldType { base, count }
}
