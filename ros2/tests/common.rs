//! Ports with common messages.

use std::collections::BTreeMap;

use dotgen_analysis::host::UnitResult;
use dotgen_codegen::codels::value::Values;
use dotgen_ros2::cdr::Stamp;
use dotgen_ros2::common;
use dotgen_ros2::conversion::{Conversion, conversions};
use dotgen_ros2::description::Types;
use dotgen_ros2::interfaces::interfaces;
use dotgen_ros2::node::endpoints;
use dotgen_ros2::rules::{Rule, Rules, check};
use serde_json::{Value, json};

use super::unit;

const POM: &str = "module est {
  struct ts { long sec, nsec; };
  struct pos { double x, y, z; };
  struct att { double qw, qx, qy, qz; };
  union either switch (boolean) { case TRUE: double d; };
  struct state {
    ts when; string<8> body; optional<pos> at; optional<att> att; double cov[36]; float low;
    long long big; unsigned short small; boolean ok; sequence<double> list; either one;
  };
};
component pom {
  version \"1\"; lang \"c\";
  port out est::state frame;
  port in est::state goal;
};
";

/// Hashes of the packages that ROS 2 Jazzy installs. None is computed by this crate.
const JAZZY: &str = "
builtin_interfaces/msg/Time b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197
std_msgs/msg/Header f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01
geometry_msgs/msg/Point 6963084842a9b04494d6b2941d11444708d892da2f4b09843b9c43f42a7f6881
geometry_msgs/msg/Quaternion 8a765f66778c8ff7c8ab94afcc590a2ed5325a1d9a076ffff38fbce36f458684
geometry_msgs/msg/Vector3 cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d
geometry_msgs/msg/Pose d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa
geometry_msgs/msg/PoseStamped 10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8
geometry_msgs/msg/PoseWithCovariance 9a7c0fd234b7f45c6098745ecccd773ca1085670e64107135397aee31c02e1bb
geometry_msgs/msg/Twist 9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a
geometry_msgs/msg/TwistStamped 5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64
geometry_msgs/msg/TwistWithCovariance 49f574f033f095d8b6cd1beaca5ca7925e296e84af1716d16c89d38b059c8c18
nav_msgs/msg/Odometry 3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0
sensor_msgs/msg/Imu 7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b
sensor_msgs/msg/Image d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47
sensor_msgs/msg/RegionOfInterest ad16bcba5f9131dcdba6fbded19f726f5440e3c513b4fb586dd3027eeed8abb1
sensor_msgs/msg/CameraInfo b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275
sensor_msgs/msg/LaserScan 64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828
sensor_msgs/msg/PointField 5c6a4750728c2bcfbbf7037225b20b02d4429634732146b742dee1726637ef01
sensor_msgs/msg/PointCloud2 9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5
sensor_msgs/msg/JointState a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e
";

pub(crate) fn rules(port: &str, message: &str, fields: &Value, constants: &Value) -> Rules {
    let table = |value: &Value| -> BTreeMap<String, Value> {
        let entries = value.as_object().into_iter().flatten();
        entries.map(|(key, value)| (key.clone(), value.clone())).collect()
    };
    let rule =
        Rule { message: message.to_owned(), fields: table(fields), constants: table(constants) };
    let ports = BTreeMap::from([(port.to_owned(), rule)]);
    BTreeMap::from([("pom".to_owned(), ports)])
}

pub(crate) fn conversion(unit: &UnitResult, rules: &Rules) -> Conversion {
    let found = conversions(&unit.spec, &unit.spec.components.raw[0], rules);
    let mut found = found.unwrap_or_else(|errors| panic!("{errors:?}"));
    found.pop_first().expect("a port").1
}

/// The data of a port with a state.
pub(crate) fn data(unit: &UnitResult, state: &Value) -> Vec<u8> {
    let port = &unit.spec.components.raw[0].ports.raw[0];
    Values::new(&unit.spec).encode(port.data, state).expect("a state")
}

fn pose() -> Value {
    json!({
        "header.stamp": "when", "pose": {"position": "at", "orientation": {"x": "att.qx", "w": "att.qw"}},
    })
}

pub(crate) const NOW: Stamp = Stamp { sec: 7, nanosec: 8 };

/// A `PoseStamped` in the frame `map`.
fn pose_stamped(stamp: (i32, u32), numbers: [f64; 7]) -> Vec<u8> {
    let mut out = vec![0, 1, 0, 0];
    out.extend(stamp.0.to_le_bytes());
    out.extend(stamp.1.to_le_bytes());
    out.extend([4, 0, 0, 0, b'm', b'a', b'p', 0]);
    out.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    out
}

#[test]
fn hashes_are_those_of_jazzy() {
    let mut types = Types::default();
    common::names().for_each(|name| common::add(name, &mut types));
    let known = JAZZY.lines().filter_map(|line| line.split_once(' '));
    let known: BTreeMap<&str, String> =
        known.map(|(name, hash)| (name, format!("RIHS01_{hash}"))).collect();
    let found: BTreeMap<&str, String> =
        common::names().map(|name| (name, types.hash(name))).collect();
    assert_eq!(found, known);
}

#[test]
fn an_output_port_is_published_as_its_message() {
    let unit = unit(POM);
    let constants = json!({"header": {"frame_id": "map"}, "pose.orientation.z": 2});
    let rules = rules("frame", "geometry_msgs/PoseStamped", &pose(), &constants);
    assert_eq!(check(&rules), []);
    let conversion = conversion(&unit, &rules);
    let mut state = json!({
        "when": {"sec": 3, "nsec": 4}, "body": "arm", "list": [1.0, 2.0], "one": {"_d": true, "d": 1.0},
        "at": {"x": 1.0, "y": 2.0, "z": 0.5}, "att": {"qw": 0.5, "qx": -0.5, "qy": 9.0, "qz": 9.0},
    });
    let message = |state: &Value| conversion.message(&unit.spec, &data(&unit, state), NOW);
    let expected = pose_stamped((3, 4), [1.0, 2.0, 0.5, -0.5, 0.0, 2.0, 0.5]);
    assert_eq!(message(&state), Ok(Some(expected)));
    // An optional member is absent.
    state["att"] = Value::Null;
    assert_eq!(message(&state), Ok(None));
    // No moment of ROS 2.
    state["att"] = json!({});
    state["when"] = json!({"sec": 3, "nsec": -1});
    let why = message(&state).expect_err("no moment").to_string();
    assert!(why.starts_with("`header.stamp.nanosec` has to be a time"), "{why}");
    state["when"] = json!({"sec": 3, "nsec": 1_000_000_000});
    assert!(message(&state).is_err());
    assert!(conversion.message(&unit.spec, &[0; 5], NOW).is_err());
}

#[test]
fn fields_without_a_source_have_the_defaults_of_ros() {
    let unit = unit(POM);
    let (fields, frame) = (json!({"pose.position.x": "low"}), json!({"header.frame_id": "map"}));
    let rules = rules("frame", "geometry_msgs/msg/PoseStamped", &fields, &frame);
    let conversion = conversion(&unit, &rules);
    let message = conversion.message(&unit.spec, &data(&unit, &json!({"low": 0.25})), NOW);
    let expected = pose_stamped((7, 8), [0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!(message, Ok(Some(expected)));
}

#[test]
fn an_input_port_has_the_members_of_its_message() {
    let unit = unit(POM);
    let rules = rules("goal", "geometry_msgs/PoseStamped", &pose(), &json!({}));
    let conversion = conversion(&unit, &rules);
    let message = pose_stamped((3, 4), [1.0, f64::INFINITY, 0.5, -0.5, 0.0, 2.0, 0.25]);
    let found = conversion.data(&unit.spec, &message).expect("a state");
    let mut expected = json!({
        "when": {"sec": 3, "nsec": 4}, "at": {"x": 1.0, "y": 1e300, "z": 0.5}, "att": {"qw": 0.25, "qx": -0.5},
    });
    let finite = data(&unit, &expected);
    // JSON has no infinity.
    let at = finite.windows(8).position(|bytes| bytes == 1e300f64.to_ne_bytes());
    let mut bytes = finite.clone();
    bytes[at.expect("it is there")..][..8].copy_from_slice(&f64::INFINITY.to_ne_bytes());
    assert_eq!(found, bytes);
    expected["att"]["qw"] = json!(0.5);
    assert_ne!(found, data(&unit, &expected));
    // Malformed messages, and a time that the member does not hold.
    for end in 0..message.len() {
        assert!(conversion.data(&unit.spec, &message[..end]).is_err(), "{end}");
    }
    let late = pose_stamped((3, u32::MAX), [0.0; 7]);
    assert!(conversion.data(&unit.spec, &late).is_err());
}

#[test]
fn arrays_are_assigned_by_element() {
    let unit = unit(POM);
    let fields = json!({"pose.covariance": "cov", "child_frame_id": "body", "twist.twist.linear.x": "small"});
    let constants = json!({"twist.covariance[1]": 5, "pose.pose.position": [1, 2.5, 3]});
    let rules = rules("frame", "nav_msgs/Odometry", &fields, &constants);
    let conversion = conversion(&unit, &rules);
    let cov: Vec<f64> = (0..36).map(f64::from).collect();
    let state = json!({"cov": cov, "body": "arm", "small": 9});
    let message = conversion.message(&unit.spec, &data(&unit, &state), NOW);
    let message = message.expect("it fits").expect("all is there");
    let number = |at: usize| {
        let bytes = message[4 + 24 + 8 * at..][..8].try_into();
        f64::from_le_bytes(bytes.expect("eight bytes"))
    };
    // After the time, the empty name of the frame, and that of the body.
    assert_eq!(message[12..28], *b"\x01\0\0\0\0\0\0\0\x04\0\0\0arm\0");
    assert_eq!([number(0), number(1), number(2), number(6)], [1.0, 2.5, 3.0, 1.0]);
    let found: Vec<f64> = (7..43).map(number).collect();
    assert_eq!(found, cov);
    assert_eq!([number(43), number(49), number(50)], [9.0, 0.0, 5.0]);
    assert_eq!(message.len(), 4 + 24 + 8 * (7 + 36 + 6 + 36));
}

#[test]
fn wrong_rules_are_told_with_their_place() {
    let unit = unit(POM);
    let none = json!({});
    let stamped = |port: &str, fields: &Value, constants: &Value| {
        rules(port, "geometry_msgs/PoseStamped", fields, constants)
    };
    let field =
        |port: &str, field: &str, member: Value| stamped(port, &json!({ field: member }), &none);
    let constant = |field: &str, value: Value| {
        stamped("frame", &json!({"pose.position": "at"}), &json!({ field: value }))
    };
    let x = "pose.position.x";
    let wrong = [
        rules("frme", "geometry_msgs/Pose", &pose(), &none),
        rules("frame", "geometry_msgs/Pos", &pose(), &none),
        rules("frame", "geometry_msgs/Twist", &pose(), &none),
        stamped("frame", &none, &none),
        stamped("goal", &pose(), &json!({"header.frame_id": "map"})),
        stamped("frame", &json!({x: "low", "pose.position": "at"}), &none),
        stamped("goal", &json!({x: "at.x", "pose.position.y": "at.x"}), &none),
        field("frame", "pose.positoin.x", json!("low")),
        field("frame", "pose.position.x.y", json!("low")),
        rules("frame", "sensor_msgs/Imu", &json!({"orientation_covariance[9]": "low"}), &none),
        field("frame", x, json!(1.5)),
        field("frame", x, json!("at.q")),
        field("frame", x, json!("cov")),
        field("frame", x, json!("cov[36]")),
        field("frame", x, json!("cov.x")),
        field("frame", x, json!("list[0]")),
        field("frame", x, json!("one.d")),
        field("frame", x, json!("low.x")),
        field("frame", x, json!("big")),
        field("frame", x, json!("ok")),
        field("frame", x, json!("body")),
        field("frame", "header.stamp.sec", json!("low")),
        field("goal", x, json!("low")),
        field("goal", "header.frame_id", json!("body")),
        constant("header.frame_id", json!(1)),
        constant("header.stamp.nanosec", json!(-1)),
        constant("pose.orientation", json!([0, 1])),
        constant("pose.orientation.w", json!([0, 1])),
    ];
    let mut all = String::new();
    for rules in wrong {
        let errors = conversions(&unit.spec, &unit.spec.components.raw[0], &rules);
        for error in errors.expect_err("a rule is wrong") {
            all += &format!("{error}\n");
        }
    }
    insta::assert_snapshot!(all);
}

#[test]
fn a_port_with_a_rule_needs_no_type_of_its_own() {
    let unit = unit(&POM.replace("  port in est::state goal;\n", ""));
    let (spec, component) = (&unit.spec, &unit.spec.components.raw[0]);
    let rules = rules("frame", "geometry_msgs/PoseStamped", &pose(), &json!({}));
    let found = conversions(spec, component, &rules).expect("it is right");
    let node = endpoints(spec, component, 0, found).expect("it has a name");
    assert_eq!(node.endpoints[0].type_name, "geometry_msgs/msg/PoseStamped");
    assert!(JAZZY.contains(&node.endpoints[0].hash["RIHS01_".len()..]));
    let found = interfaces(spec, &[component], &rules).expect("it is right");
    assert_eq!((found.files, found.refused), (BTreeMap::new(), Vec::new()));
    let found = interfaces(spec, &[component], &Rules::new()).expect("it is right");
    assert!(found.files.contains_key("est/msg/State.msg"), "{found:?}");
}
