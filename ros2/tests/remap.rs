//! Other names of topics, services and actions.

use dotgen_ros2::conversion::Conversions;
use dotgen_ros2::node::{Node, endpoints};
use dotgen_ros2::remap::{Remap, remap};

use super::unit;

const MOTOR: &str = "typedef double number; typedef long whole;
component motor {
  version \"1\"; lang \"c\";
  task t { };
  port out number speed;
  port in number wanted;
  port out whole count;
  port multiple out number each;
  function stop();
  function reset();
  activity turn(in double angle) { codel<start> go() yield ether; task t; };
};";

fn renamed(texts: &[&str]) -> Result<Node, String> {
    let remaps = texts.iter().map(|text| text.parse()).collect::<Result<Vec<Remap>, String>>()?;
    let unit = unit(MOTOR);
    let node = endpoints(&unit.spec, &unit.spec.components.raw[0], 0, Conversions::new());
    let mut node = node.expect("it has a name");
    remap(&remaps, &mut [&mut node])?;
    Ok(node)
}

fn topics(texts: &[&str]) -> Vec<String> {
    let node = renamed(texts).expect("they are right");
    node.endpoints.into_iter().map(|endpoint| endpoint.topic).collect()
}

#[test]
fn topics_services_and_actions_get_other_names() {
    let found = topics(&[
        "/motor/speed:=/odom",
        "motor/stop:=/a/b",
        "/motor/turn:=/spin",
        "motor/each:=/all",
    ]);
    let expected = [
        "/odom",
        "/motor/wanted",
        "/motor/count",
        "/all",
        "/a/b",
        "/motor/reset",
        "/spin/_action/send_goal",
        "/spin/_action/get_result",
        "/spin/_action/cancel_goal",
        "/spin/_action/feedback",
        "/spin/_action/status",
    ];
    assert_eq!(found, expected);
    // Names may be exchanged, and ports of one type may share a topic.
    let found = topics(&["/motor/speed:=/motor/wanted", "/motor/wanted:=/motor/speed"]);
    assert_eq!(found[..2], ["/motor/wanted", "/motor/speed"]);
    let found = topics(&["/motor/speed:=/x", "/motor/wanted:=/x"]);
    assert_eq!(found[..2], ["/x", "/x"]);
    let node = renamed(&["/motor/each:=/all"]).expect("it is right");
    let each = node.endpoints[3].instance("left").expect("it has a name");
    assert_eq!(each.topic, "/all/left");
}

#[test]
fn wrong_names_are_told() {
    let long = format!("/motor/speed:=/{}", "a".repeat(247));
    let mut all = String::new();
    for texts in [
        &["/motor/speed"][..],
        &["/motor/speed:=odom"],
        &["/motor/speed:=/"],
        &["/motor/speed:=/a//b"],
        &["/motor/speed:=/a/"],
        &["/motor/speed:=/1a"],
        &["/motor/speed:=/a-b"],
        &[":=/a"],
        &["~/speed:=/a"],
        &[long.as_str()],
        &["/motor/sped:=/a"],
        &["/pump/level/of/oil:=/a"],
        &["/motor/speed:=/a", "motor/speed:=/b"],
        &["/motor/speed:=/motor/count"],
        &["/motor/stop:=/motor/reset"],
    ] {
        match renamed(texts) {
            Ok(_) => all += &format!("accepted: {texts:?}\n"),
            Err(why) => all += &format!("{why}\n"),
        }
    }
    insta::assert_snapshot!(all);
}
