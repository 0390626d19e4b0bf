//! Types that masquerade as common messages.

use dotgen_analysis::host::UnitResult;
use dotgen_ros2::conversion::{Conversions, conversions};
use dotgen_ros2::interfaces::interfaces;
use dotgen_ros2::node::{Node, Part, endpoints};
use dotgen_ros2::rules::Rules;
use serde_json::json;

use super::common::{NOW, data, rules};
use super::unit;

/// A component with a type `g::t`, which masquerades, and its parts.
fn component(members: &str, pragma: &str, parts: &str) -> UnitResult {
    unit(&format!(
        "module g {{
  struct vec {{ double x, y, z; }};
  struct time {{ long sec; unsigned long nsec; }};
  struct head {{ time stamp; string frame_id; }};
  struct odd {{ float x; double y, z; }};
  struct t {{ {members} }};
}};
#pragma masquerade {pragma}
component pom {{ version \"1\"; lang \"c\"; {parts} }};"
    ))
}

const TWIST: &str = "vec linear, angular;";
const PORT: &str = "port out g::t frame;";

fn node(unit: &UnitResult) -> Node {
    endpoints(&unit.spec, &unit.spec.components.raw[0], 0, Conversions::new())
        .expect("it has a name")
}

fn type_name(members: &str, pragma: &str) -> String {
    let node = node(&component(members, pragma, PORT));
    match node.refused.first() {
        Some(refusal) => refusal.to_string(),
        None => node.endpoints[0].type_name.clone(),
    }
}

#[test]
fn a_port_publishes_the_message_of_its_type() {
    let twist = "geometry_msgs/msg/Twist";
    for pragma in [
        "ros ::g::t \"geometry_msgs/Twist\"",
        "ros g::t \"geometry_msgs::Twist\"",
        "ros2 g::t \"geometry_msgs/msg/Twist\"",
        "ros/server g::t \"::geometry_msgs::msg::Twist\"",
    ] {
        assert_eq!(type_name(TWIST, pragma), twist, "{pragma}");
    }
    // In another order of members.
    assert_eq!(type_name("vec angular, linear;", "ros g::t \"geometry_msgs/Twist\""), twist);
    assert_eq!(type_name(TWIST, "pocolibs g::t \"geometry_msgs/Twist\""), "g/msg/T");
    assert_eq!(type_name(TWIST, "rosix g::t \"geometry_msgs/Twist\""), "g/msg/T");
    let two =
        "ros g::t \"geometry_msgs/Pose\"\n#pragma masquerade ros2 g::t \"geometry_msgs/Twist\"";
    assert_eq!(type_name(TWIST, two), twist);
}

#[test]
fn its_messages_have_the_values_of_its_members() {
    let pragma = "ros g::t \"geometry_msgs/TwistStamped\"";
    let value = |stamp: bool| {
        let mut head = json!({"frame_id": "map", "stamp": {"sec": 3, "nsec": 4}});
        if !stamp {
            head.as_object_mut().expect("a table").remove("stamp");
        }
        json!({"header": head, "twist": {"angular": {"z": 0.5}}})
    };
    let twist = "struct tw { vec linear, angular; } twist;";
    for (head, has_stamp) in [
        ("head header;", true),
        ("struct bare { string frame_id; unsigned long seq; } header;", false),
    ] {
        let unit = component(&format!("{head} {twist}"), pragma, PORT);
        let node = node(&unit);
        assert_eq!((node.refused.as_slice(), node.conversions.len()), (&[][..], 1));
        let conversion = &node.conversions[&0.into()];
        let message = conversion.message(&unit.spec, &data(&unit, &value(has_stamp)), NOW);
        let mut expected = vec![0, 1, 0, 0];
        expected.extend(if has_stamp {
            [3, 0, 0, 0, 4, 0, 0, 0]
        } else {
            [7, 0, 0, 0, 8, 0, 0, 0]
        });
        expected.extend([4, 0, 0, 0, b'm', b'a', b'p', 0]);
        expected.extend([0; 40]);
        expected.extend(0.5f64.to_le_bytes());
        assert_eq!(message, Ok(Some(expected)));
    }
}

#[test]
fn differences_are_told() {
    let twist = "ros g::t \"geometry_msgs/Twist\"";
    let mut all = String::new();
    for (members, pragma) in [
        ("vec linear;", twist),
        ("vec linear, angular; double more;", twist),
        ("vec linear; odd angular;", twist),
        ("vec linear; double angular;", twist),
        (TWIST, "ros g::t \"geometry_msgs/Twst\""),
        (TWIST, "ros g::t \"stereo_msgs/DisparityImage\""),
        (
            "struct p { vec position; } pose; double covariance[36];",
            "ros g::t \"geometry_msgs/PoseWithCovariance\"",
        ),
        ("head header; float angle_min;", "ros2 g::t \"sensor_msgs::LaserScan\""),
        (
            "head header; sequence<string> name; sequence<float> position;",
            "ros g::t \"sensor_msgs/JointState\"",
        ),
    ] {
        all += &format!("{}\n", type_name(members, pragma));
    }
    insta::assert_snapshot!(all);
}

#[test]
fn parameters_and_members_are_messages_with_the_same_payload() {
    let pragma = "ros g::vec \"geometry_msgs/Vector3\"";
    let parts = "port out g::t frame; function go(in g::vec to, out sequence<g::vec> way);";
    let unit = component(TWIST, pragma, parts);
    let node = node(&unit);
    assert_eq!(node.refused, []);
    let type_of = |name: &str| {
        let fields = node.types.fields(name).expect("a type");
        fields.iter().map(|field| field.ty.text()).collect::<Vec<_>>()
    };
    assert_eq!(type_of("g/msg/T"), ["geometry_msgs/Vector3", "geometry_msgs/Vector3"]);
    assert_eq!(type_of("pom/srv/Go_Request"), ["geometry_msgs/Vector3"]);
    assert_eq!(type_of("pom/srv/Go_Response"), ["geometry_msgs/Vector3[]", "string"]);
    let found = interfaces(&unit.spec, &[&unit.spec.components.raw[0]], &Rules::new());
    let files = found.expect("no rules").files;
    assert_eq!(files["pom/srv/Go.srv"].lines().nth(1), Some("geometry_msgs/Vector3 to"));
    assert!(files["g/package.xml"].contains("<depend>geometry_msgs</depend>"), "{files:?}");
    // Parameters are not converted.
    let unit = component(
        "vec angular, linear;",
        "ros g::t \"geometry_msgs/Twist\"",
        "function go(in g::t to);",
    );
    let node = self::node(&unit);
    let why = "`linear` is not member 1, its place in `geometry_msgs/Twist`";
    assert!(node.refused[0].why.contains(why), "{:?}", node.refused);
}

#[test]
fn rules_win() {
    let unit = component("vec linear;", "ros g::t \"geometry_msgs/Twist\"", PORT);
    let (spec, component) = (&unit.spec, &unit.spec.components.raw[0]);
    let rules = rules("frame", "geometry_msgs/Point", &json!({"x": "linear.x"}), &json!({}));
    let found = conversions(spec, component, &rules).expect("it is right");
    let node = endpoints(spec, component, 0, found).expect("it has a name");
    assert_eq!(node.refused, []);
    assert_eq!(node.endpoints[0].type_name, "geometry_msgs/msg/Point");
    assert_eq!(node.endpoints[0].part, Part::Port(0.into()));
}
