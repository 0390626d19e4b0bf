//! Common messages of ROS 2, which ports can have instead of messages of their own types.

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
];

/// Nanoseconds of a second.
pub(crate) const SECOND: u32 = 1_000_000_000;

/// A number or string of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Leaf {
    /// The path within the message: `pose.covariance[3]`.
    pub(crate) path: String,
    /// The type: a number or a string.
    pub(crate) base: Base,
    /// The value if nothing is assigned.
    pub(crate) default: i32,
    /// True for the parts of a moment.
    pub(crate) is_time: bool,
}

/// The names of all common messages: `geometry_msgs/msg/Pose`.
pub fn names() -> impl Iterator<Item = &'static str> {
    COMMON.iter().map(|common| common.0)
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
        if let Base::Nested(name) = &field.ty.base {
            add_leaves(name, &format!("{path}."), out);
            continue;
        }
        let paths = match field.ty.count {
            Count::Exactly(number) => (0..number).map(|at| format!("{path}[{at}]")).collect(),
            _ => vec![path],
        };
        out.extend(paths.into_iter().map(|path| Leaf {
            path,
            base: field.ty.base.clone(),
            default,
            is_time: name == crate::description::TIME,
        }));
    }
}

/// The fields of a common message, with their defaults.
fn fields(name: &str) -> impl Iterator<Item = (Field, i32)> {
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
    let (base, length) = text.split_once('[').unwrap_or((text, ""));
    let length = length.trim_end_matches(']').parse();
    let base = match base {
        "int32" => Base::Int32,
        "uint32" => Base::Uint32,
        "float64" => Base::Float64,
        "string" => Base::String,
        nested => Base::Nested(nested.replacen('/', "/msg/", 1)),
    };
    let count = length.map_or(Count::One, Count::Exactly);
    FieldType { base, count }
}
