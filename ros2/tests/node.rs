//! The endpoints of components.

use dotgen_ros2::conversion::Conversions;
use dotgen_ros2::node::{Endpoint, Node, endpoints};
use dotgen_ros2::wire::NodeId;

use super::{PUMP, unit};

fn node(text: &str) -> Node {
    let unit = unit(text);
    let spec = &unit.spec;
    endpoints(spec, &spec.components.raw[0], 7, Conversions::new()).expect("it has a name")
}

fn refused(text: &str) -> Vec<String> {
    node(text).refused.iter().map(ToString::to_string).collect()
}

#[test]
fn a_component_is_a_node() {
    let node = node(PUMP);
    assert_eq!(node.refused, []);
    let lines = node.endpoints.iter().map(|endpoint| {
        let mut key = endpoint.key(node.domain);
        key.truncate(key.find("RIHS01").unwrap_or(0));
        format!("{:?} {:?} {:?} {key}", endpoint.part, endpoint.kind, endpoint.qos)
    });
    insta::assert_snapshot!(lines.collect::<Vec<_>>().join("\n"));
}

#[test]
fn types_have_the_hashes_of_rosidl() {
    let node = node(PUMP);
    for endpoint in &node.endpoints {
        let name = &endpoint.type_name;
        let mut lines = super::hashes::HASHES.lines().map(|line| line.split_once(' '));
        let known = lines.find_map(|line| line.filter(|line| line.0 == name));
        assert_eq!(known.map(|line| line.1), Some(endpoint.hash.as_str()), "{name}");
    }
}

#[test]
fn an_instance_has_its_own_topic() {
    let node = node(PUMP);
    let is_multiple = |endpoint: &&Endpoint| endpoint.multiple;
    let port = node.endpoints.iter().find(is_multiple).expect("a port");
    assert!(port.key(0).starts_with("0/tank/shapes/*/or_t3d::msg::dds_::Shape_/"));
    let left = port.instance("left").expect("a name");
    let id = NodeId { domain: 0, session: "ab", number: 1, name: &node.name };
    let token = left.token(id, 9);
    let start = "@ros2_lv/0/ab/1/9/MP/%/%/tank/%tank%shapes%left/or_t3d::msg::dds_::Shape_/RIHS01_";
    assert!(token.starts_with(start), "{token}");
    assert!(port.instance("1/*").is_err());
}

#[test]
fn parts_without_a_form_are_refused() {
    let text = "
        module std_msgs { struct three { long x; }; };
        module a_b { struct one { long x; }; };
        module a { module b { struct two { long x; }; }; };
        module or { struct lonely { long x; }; };
        struct moveTo { long x; };
        struct move_to { long x; };
        struct twice { long posX; long pos_x; };
        struct word { long class; };
        struct loop;
        struct loop { sequence<loop> all; };
        enum both { up, UP };
        component demo {
            version \"1.0\"; lang \"c\";
            port out std_msgs::three p_standard;
            port out a_b::one p_one;
            port out a::b::two p_package;
            port out or::lonely p_keyword;
            port out moveTo p_first;
            port out move_to p_second;
            port out twice p_fields;
            port out word p_word;
            port out loop p_loop;
            port out both p_both;
            function exception_(out long exception) { codel f(local out exception); };
            function fine();
        };";
    insta::assert_snapshot!(refused(text).join("\n"));
    assert_eq!(node(text).endpoints.len(), 3);
}

/// The type of the port is a sequence of a sequence of … as deep as given.
fn deep(depth: usize) -> Vec<String> {
    let mut text = "module m { typedef sequence<long> t0;".to_owned();
    for level in 1..depth {
        text += &format!("typedef sequence<t{}> t{level};", level - 1);
    }
    text += &format!(
        "}}; component demo {{ version \"1\"; lang \"c\"; port out m::t{} p; }};",
        depth - 1
    );
    refused(&text)
}

#[test]
fn types_have_a_maximum_depth() {
    assert_eq!(deep(50), [""; 0]);
    let found = deep(500);
    assert!(found.len() == 1 && found[0].contains("deeper than"), "{found:?}");
}

#[test]
fn a_component_that_is_a_keyword_is_refused() {
    let unit = unit("component or { version \"1\"; lang \"c\"; };");
    let found = endpoints(&unit.spec, &unit.spec.components.raw[0], 0, Conversions::new())
        .expect_err("a keyword");
    assert!(found[0].to_string().contains("keyword"), "{}", found[0]);
}

#[test]
fn two_types_that_would_be_one_message_are_refused() {
    let text = "typedef sequence<sequence<double> > rows;
    typedef sequence<sequence<long> > counts;
    component c {
      ids { double x; };
      function set(in rows goal_pos) { codel f(in goal_pos); };
      function set_goal(in counts pos) { codel g(in pos); };
    };\n";
    let refused = refused(text);
    assert_eq!(refused.len(), 1, "{refused:?}");
    assert!(refused[0].contains("two types would be"), "{refused:?}");
}
